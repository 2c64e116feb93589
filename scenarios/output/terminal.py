"""Run a command from the command line: arguments, progress bars, errors and exit status."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Protocol

import tyro
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from flybench.disk_space import caused_by_full_disk
from flybench.errors import FlybenchError
from scenarios.output.repetition import check_repetition


class Command(Protocol):
    """A sub-command: a dataclass whose fields are the command-line arguments."""

    def execute(self) -> int:
        """Run the command and return the exit status of the process."""
        ...


class ProgressBars:
    """Progress bars of several sequences, one line each."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress

    def track(self, name: str) -> Callable[[int, int], None]:
        """Add a bar.

        Args:
            name: label of the bar.

        Returns:
            Function that sets the bar from the amount done and the total, such as times in µs.
        """
        task = self._progress.add_task(name, total=None)

        def advance(done: int, total: int) -> None:
            self._progress.update(task, completed=done, total=total)

        return advance


@contextmanager
def progress_bar(speed_over_s: float = 30.0) -> Iterator[ProgressBars]:
    """Show progress bars on standard error while the block runs.

    Args:
        speed_over_s: period over which the speed is averaged to estimate the time left [s]; choose
            a long period for long steps.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    console = Console(stderr=True)
    with Progress(*columns, console=console, speed_estimate_period=speed_over_s) as progress:
        yield ProgressBars(progress)


def has_display() -> bool:
    """Return True if a window can be opened."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def run_cli(command: Any, *, prog: str | None = None, description: str | None = None) -> None:
    """Run a command with the arguments of this process, and exit with its status.

    Args:
        command: class of the command, or a union of classes for sub-commands.
        prog: name of the program in the help; None: that of the script.
        description: text above the options in the help; None: the docstring of the class.
    """
    try:
        chosen = tyro.cli(command, prog=prog, description=description)
        check_repetition(sys.argv[1:], also_repeatable=getattr(chosen, "REPEATABLE", ()))
    except FlybenchError as error:  # raised by arguments that check themselves
        print(f"flybench: {error}", file=sys.stderr)
        sys.exit(2)
    sys.exit(execute(chosen))


def execute(command: Command) -> int:
    """Run a command and return the exit status of the process.

    A `FlybenchError` is printed on standard error without a traceback; the status is then 2.
    SIGTERM and SIGHUP act like Ctrl-C, so that temporary files are removed; the status is then 130.
    """
    _handle_signals_as_interrupt()
    try:
        return command.execute()
    except FlybenchError as error:
        print(f"flybench: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return _interrupted()
    except SystemError as error:
        if not _is_interrupt(error):
            raise
        return _interrupted()
    except BrokenPipeError:  # the reader of our output has closed it; discard the rest
        _discard_output()
        return 1
    except OSError as error:
        if not caused_by_full_disk(error):
            raise
        try:
            sys.stdout.flush()
        except OSError:  # it is the standard output that has no room
            _discard_output()
        where = f" of {error.filename}" if error.filename else ""
        print(
            f"flybench: The disk{where} is full ({error.strerror}). It is that of the output, of "
            f"{tempfile.gettempdir()} or of the standard output. Free some space there.",
            file=sys.stderr,
        )
        return 2


def _discard_output() -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _handle_signals_as_interrupt() -> None:
    """Handle SIGTERM and SIGHUP like Ctrl-C, but leave SIGHUP ignored under nohup."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    hangup = getattr(signal, "SIGHUP", None)  # Windows does not have it
    if hangup is not None and signal.getsignal(hangup) is not signal.SIG_IGN:
        signal.signal(hangup, signal.default_int_handler)


def _interrupted() -> int:
    with suppress(OSError):  # the terminal may be closed
        print("flybench: interrupted", file=sys.stderr)
    return 130


def _is_interrupt(error: BaseException | None) -> bool:
    """Return True if Ctrl-C caused the error: numba turns it into a SystemError."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None
