"""Exit status and errors of commands."""

import errno
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from rich.table import Table

from flybench.memory import VARIABLE
from formats import FormatError
from scenarios.output.streams import SafeConsole, say
from scenarios.output.terminal import execute
from tests.scenarios.in_process import exit_status

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


def test_text_is_printed_as_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table("[/red] :smile:", title="[bold]\x1b[2J")
    table.add_row("[/red]\x1b]0;title\x07")
    SafeConsole(width=60).print(table)
    SafeConsole(width=60).print("[/green] \x1b[31m")
    say("done: \x1b[31m")
    shown = capsys.readouterr().out
    assert "\x1b" not in shown
    for part in ("[/red] :smile:", "[bold]\\x1b[2J", "[/red]\\x1b]0;title\\x07", "done: \\x1b[31m"):
        assert part in shown


def test_memory_that_runs_out_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    class Command:
        def execute(self) -> int:
            raise MemoryError

    assert execute(Command()) == 2
    assert capsys.readouterr().err.startswith("flybench: memory ran out. ")


@pytest.fixture
def run_flybench(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str]]:
    """Function that runs flybench, and returns its exit status and what it printed."""
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setenv("COLUMNS", "200")

    def run(*arguments: str) -> tuple[int, str]:
        status, printed = exit_status(arguments), capsys.readouterr()
        return status, printed.out + printed.err

    return run


def test_the_budget_is_an_option_of_every_command(
    tmp_path: Path, run_flybench: Callable[..., tuple[int, str]]
) -> None:
    path = tmp_path / "large.csv"
    path.write_text("0,0,0,1\n10,29000,28000,1\n20,5,5,0\n")
    detect = ("detect", str(path), "--columns", "txyp")
    for arguments in (detect, ("--memory-gb", "3", *detect)):
        status, shown = run_flybench(*arguments)
        assert status == 2
        assert "A fly of 29001×28001 px needs" in shown
        assert f"Allowed is {3 if '3' in arguments else 4} GB" in shown
        assert "--memory-gb" in shown
        assert len(shown.strip().splitlines()) == 1


def test_a_sweep_with_markup_in_its_names_is_shown(
    tmp_path: Path, run_flybench: Callable[..., tuple[int, str]]
) -> None:
    path = tmp_path / "[red].toml"
    path.write_text('[[levels."[/green]"]]\nname = "[/red] \\u001b[2J"\nseed = 1\n')
    status, shown = run_flybench("sweep", str(path), "--dry-run", "--out", str(tmp_path / "out"))
    assert (status, "\x1b" in shown) == (0, False), shown
    assert "[/green]" in shown
    assert "[/red] \\x1b[2J" in shown
