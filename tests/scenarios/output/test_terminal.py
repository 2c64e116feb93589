"""Exit status and errors of commands."""

import errno
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from formats import FormatError
from scenarios.output.terminal import execute

PRINTS_MUCH = """
import sys
from scenarios.output.terminal import execute

class PrintsMuch:
    def execute(self):
        for _ in range(100_000):
            print("a line of some length")
        return 0

sys.exit(execute(PrintsMuch()))
"""


def test_a_closed_output_pipe_gives_no_traceback() -> None:
    command = [sys.executable, "-c", PRINTS_MUCH]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.read(10)
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 1


def test_an_error_is_printed_without_a_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    class Reader:
        def execute(self) -> int:
            raise FormatError("a.raw is truncated. Copy it again.")

    assert execute(Reader()) == 2
    assert capsys.readouterr().err == "flybench: a.raw is truncated. Copy it again.\n"


def test_ctrl_c_in_compiled_code_is_an_interrupt(capsys: pytest.CaptureFixture[str]) -> None:
    """numba raises SystemError "CPUDispatcher(...) returned a result with an exception set"."""

    class Compiled:
        def execute(self) -> int:
            try:
                raise KeyboardInterrupt
            except KeyboardInterrupt as interrupt:
                raise SystemError("returned a result with an exception set") from interrupt

    assert execute(Compiled()) == 130
    assert capsys.readouterr().err == "flybench: interrupted\n"


def test_other_system_errors_are_raised() -> None:
    class Broken:
        def execute(self) -> int:
            raise SystemError("bad argument to internal function")

    with pytest.raises(SystemError, match="bad argument"):
        execute(Broken())


SLEEPS = """
import signal, sys, tempfile, time
from scenarios.output.terminal import execute

class Sleeps:
    def execute(self):
        with tempfile.TemporaryDirectory(dir=sys.argv[1]):
            print("asleep", flush=True)
            time.sleep(60)
        return 0

signal.signal(signal.SIGINT, signal.default_int_handler)  # neither may be inherited as ignored
signal.signal(signal.SIGHUP, signal.SIG_DFL)
sys.exit(execute(Sleeps()))
"""


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_command_removes_its_temporary_files(
    how: signal.Signals, tmp_path: Path
) -> None:
    command = [sys.executable, "-c", SLEEPS, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == b"asleep\n"
        assert list(tmp_path.iterdir())
        process.send_signal(how)
        assert process.stderr.read() == b"flybench: interrupted\n"
        assert process.wait() == 130
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_elsewhere_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    class Full:
        def execute(self) -> int:
            raise OSError(errno.ENOSPC, "No space left on device", "/somewhere/a.txt")

    assert execute(Full()) == 2
    message = capsys.readouterr().err
    assert message.startswith("flybench: The disk of /somewhere/a.txt is full (No space left")
    assert message.count("\n") == 1


def test_a_full_standard_output_is_one_sentence() -> None:
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [sys.executable, "-c", PRINTS_MUCH], stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert done.returncode == 2
    assert done.stderr.startswith(b"flybench: The disk is full (No space left on device).")
    assert done.stderr.count(b"\n") == 1
