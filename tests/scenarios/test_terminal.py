"""How commands end."""

import subprocess
import sys

import pytest

from formats import FormatError
from scenarios.terminal import execute

TALKER = """
import sys
from scenarios.terminal import execute

class Talker:
    def execute(self):
        for _ in range(100_000):
            print("a line of some length")
        return 0

sys.exit(execute(Talker()))
"""


def test_a_reader_that_has_enough_is_no_traceback() -> None:
    command = [sys.executable, "-c", TALKER]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.read(10)
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 1


def test_a_broken_recording_is_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    class Reader:
        def execute(self) -> int:
            raise FormatError("a.raw is cut; copy it again")

    assert execute(Reader()) == 2
    assert capsys.readouterr().err == "flybench: a.raw is cut; copy it again\n"
