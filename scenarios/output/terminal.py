"""What the commands show in a terminal while they work, and how they end."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Protocol

import tyro
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from flybench.errors import FlybenchError
from scenarios.options.repetition import refuse_repetition


class Command(Protocol):
    """A sub-command: a dataclass of its arguments."""

    def execute(self) -> int:
        """Do it; returns the process's exit status."""
        ...


class Bar:
    """Progress of several sequences, a line each."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress

    def track(self, name: str) -> Callable[[int, int], None]:
        """Add a line; the function returned takes the time reached and the whole [µs]."""
        task = self._progress.add_task(name, total=None)

        def advance(done_us: int, total_us: int) -> None:
            self._progress.update(task, completed=done_us, total=total_us)

        return advance


@contextmanager
def progress_bar(speed_over_s: float = 30.0) -> Iterator[Bar]:
    """Show progress bars on standard error while the block runs.

    Args:
        speed_over_s: the time left is told from the speed over so long a time [s]; make it long
            where steps are.
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
        yield Bar(progress)


def has_display() -> bool:
    """Whether a window can be opened here."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def script(command: Any) -> None:
    """Run a command class from the command line, and end the process with its status."""
    try:
        chosen = tyro.cli(command)
        refuse_repetition(sys.argv[1:], also_several=getattr(chosen, "TAKES_SEVERAL", ()))
    except FlybenchError as refusal:  # of an argument that checks itself when made
        print(f"flybench: {refusal}", file=sys.stderr)
        sys.exit(2)
    sys.exit(execute(chosen))


def execute(command: Command) -> int:
    """Run a command; a refusal becomes one sentence on standard error, and status 2.

    Being told to end is taken as an interrupt, so that what was begun is cleaned up.
    """
    _end_as_if_interrupted()
    try:
        return command.execute()
    except FlybenchError as refusal:
        print(f"flybench: {refusal}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return _interrupted()
    except SystemError as error:
        if not _is_interrupt(error):
            raise
        return _interrupted()
    except BrokenPipeError:  # whoever read our output has enough; what is left goes nowhere
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1


def _end_as_if_interrupted() -> None:
    """Take being told to end, and a terminal that closes, as Ctrl-C; but heed nohup."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    hang_up = getattr(signal, "SIGHUP", None)  # not on Windows
    if hang_up is not None and signal.getsignal(hang_up) is not signal.SIG_IGN:
        signal.signal(hang_up, signal.default_int_handler)


def _interrupted() -> int:
    with suppress(OSError):  # the terminal may be gone
        print("flybench: interrupted", file=sys.stderr)
    return 130


def _is_interrupt(error: BaseException | None) -> bool:
    """Whether it came of Ctrl-C: one within compiled code comes out of numba as a SystemError."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None
