"""What C++ says is not heard, and Python is heard again afterwards."""

import os

import pytest

from sim.render.quiet_output import suppress_output


def test_both_streams_are_quiet_for_a_while(capfd: pytest.CaptureFixture[str]) -> None:
    with suppress_output():
        for stream in (1, 2):
            os.write(stream, b"chatter")
    os.write(1, b"said")
    os.write(2, b"so")
    assert capfd.readouterr() == ("said", "so")


def test_an_error_is_heard(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KeyError), suppress_output():
        raise KeyError
    os.write(2, b"here")
    assert capfd.readouterr() == ("", "here")
