"""Run a command from the command line: arguments, progress bars, errors and exit status."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import field, make_dataclass
from typing import Annotated, Any, Protocol

import tyro
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from flybench.disk_space import caused_by_full_disk
from flybench.errors import FlybenchError
from flybench.memory import DEFAULT_GB, VARIABLE, budget_gb, set_budget
from flybench.printable import printable
from scenarios.errors import is_interrupt
from scenarios.output.repetition import check_repetition
from scenarios.output.streams import (
    SafeConsole,
    claim_output,
    complain,
    discard_output,
    own_output,
    prepare_streams,
)

_MEMORY_HELP = "Memory for large arrays in each process [GB]. What would need more is refused."
_MEMORY_HINT = f"(default: ${VARIABLE}, or {DEFAULT_GB:g})"


class Command(Protocol):
    """A sub-command: a dataclass whose fields are the command-line arguments."""

    def execute(self) -> int:
        """Run the command and return the exit status of the process."""
        ...


class Advance(Protocol):
    """Function that sets a progress bar."""

    def __call__(self, done: int, total: int, note: str = "") -> None:
        """Set the amount done, the total, and a note that follows the label of the bar."""
        ...


class ProgressBars:
    """Progress bars of several sequences, one line each."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress

    def track(self, name: str) -> Advance:
        """Add a bar.

        Args:
            name: label of the bar.

        Returns:
            Function that sets the bar from the amount done and the total, such as times in µs.
        """
        task = self._progress.add_task(printable(name), total=None)

        def advance(done: int, total: int, note: str = "") -> None:
            label = printable(f"{name}, {note}" if note else name)
            self._progress.update(task, completed=done, total=total, description=label)

        return advance


@contextmanager
def progress_bar(speed_over_s: float = 30.0) -> Iterator[ProgressBars]:
    """Show progress bars on standard error while the block runs.

    Args:
        speed_over_s: period over which the speed is averaged to estimate the time left [s]; choose
            a long period for long steps.
    """
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    console = SafeConsole(stderr=True)
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
    prepare_streams()
    try:
        arguments = tyro.cli(
            _with_shared_options(command),
            prog=prog,
            description=description or command.__doc__,
            config=(tyro.conf.CascadeSubcommandArgs,),
        )
        chosen: Any = arguments.command
        check_repetition(sys.argv[1:], also_repeatable=getattr(chosen, "REPEATABLE", ()))
        set_budget(budget_gb() if arguments.memory_gb is None else arguments.memory_gb)
    except FlybenchError as error:  # raised by arguments that check themselves
        complain(str(error))
        sys.exit(2)
    except SystemExit as end:  # the help is printed, or an argument is wrong
        sys.exit(_flushed(end.code))
    except BrokenPipeError:
        discard_output()
        sys.exit(1)
    claim_output()
    sys.exit(execute(chosen))


def _flushed(status: Any) -> Any:
    """Flush our output, and return the status; 1 if the reader of our output has closed it."""
    try:
        if own_output() is not None:
            own_output().flush()
    except BrokenPipeError:
        discard_output()
        return 1
    return status


def _with_shared_options(command: Any) -> Any:
    """Return a class whose arguments are a command, and the options that all commands share."""
    memory = tyro.conf.arg(metavar="GB", help=_MEMORY_HELP, help_behavior_hint=_MEMORY_HINT)
    arguments: list[tuple[str, Any, Any]] = [
        ("command", Annotated[command, tyro.conf.arg(name="")], field()),
        ("memory_gb", Annotated[float | None, memory], None),
    ]
    return make_dataclass("Arguments", arguments)


def execute(command: Command) -> int:
    """Run a command and return the exit status of the process.

    A `FlybenchError` is printed on standard error without a traceback; the status is then 2.
    SIGTERM and SIGHUP act like Ctrl-C, so that temporary files are removed; the status is then 130.
    """
    _handle_signals_as_interrupt()
    try:
        return int(_flushed(command.execute()))
    except FlybenchError as error:
        complain(str(error))
        return 2
    except MemoryError:
        complain("memory ran out. Close other programs, or choose something smaller.")
        return 2
    except KeyboardInterrupt:
        return _interrupted()
    except SystemError as error:
        if not is_interrupt(error):
            raise
        return _interrupted()
    except BrokenPipeError:  # the reader of our output has closed it
        discard_output()
        return 1
    except OSError as error:
        if not caused_by_full_disk(error):
            raise
        try:
            own_output().flush()
        except OSError:  # it is the standard output that has no room
            discard_output()
        where = f" of {error.filename}" if error.filename else ""
        complain(
            f"The disk{where} is full ({error.strerror}). It is that of the output, of "
            f"{tempfile.gettempdir()} or of the standard output. Free some space there."
        )
        return 2


def report_failures(reasons: Iterable[str]) -> int:
    """Print the reasons why detectors failed on standard error.

    Returns:
        The exit status of a command whose other results are complete: 1 if a detector failed.
    """
    status = 0
    for reason in reasons:
        complain(reason)
        status = 1
    return status


def _handle_signals_as_interrupt() -> None:
    """Raise KeyboardInterrupt on Ctrl-C, SIGTERM and SIGHUP; leave ignored signals ignored."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    hangup = getattr(signal, "SIGHUP", None)  # Windows does not have it
    if hangup is not None and signal.getsignal(hangup) is not signal.SIG_IGN:
        signal.signal(hangup, signal.default_int_handler)


def _interrupted() -> int:
    complain("interrupted")
    return 130
