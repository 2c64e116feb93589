"""Output of C++ code is discarded, and later output is not."""

import os

import pytest

from sim.render.quiet_output import suppress_output


def test_both_streams_are_discarded_only_inside_the_block(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with suppress_output():
        for stream in (1, 2):
            os.write(stream, b"chatter")
    os.write(1, b"standard output")
    os.write(2, b"standard error")
    assert capfd.readouterr() == ("standard output", "standard error")


def test_output_is_restored_after_an_exception(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KeyError), suppress_output():
        raise KeyError
    os.write(2, b"later")
    assert capfd.readouterr() == ("", "later")
