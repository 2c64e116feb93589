"""Progress of a command on standard error: bars on a terminal, or else a line for each phase."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task
from rich.table import Column
from rich.text import Text

from flybench.printable import printable
from scenarios.output.log import log_step
from scenarios.output.streams import SafeConsole, note

_BAR_CHARACTERS = 8
_EVERY_S, _EVERY_SHARE = 10.0, 0.1
"""Least time and share of the work between two lines about one phase (assumed)."""


class Advance(Protocol):
    """Function that reports the progress of one sequence."""

    def __call__(self, done: int, total: int, phase: str = "", note: str = "") -> None:
        """Set the amount done, the total (0 if it is unknown), the phase, and a note beside it."""
        ...


class ProgressBars(Protocol):
    """Progress of several sequences."""

    def track(self, name: str) -> Advance:
        """Add a sequence of this name, and return the function that reports its progress."""
        ...


class _State:
    shown = True
    compiling = False


@contextmanager
def show_progress(shown: bool) -> Iterator[None]:
    """Show progress while the block runs, or not."""
    before, _State.shown = _State.shown, shown
    try:
        yield
    finally:
        _State.shown = before


@contextmanager
def progress_bar(speed_over_s: float = 30.0) -> Iterator[ProgressBars]:
    """Show progress on standard error while the block runs.

    Args:
        speed_over_s: period over which the speed is averaged to estimate the time to go [s]; choose
            a long period for long steps.
    """
    console = SafeConsole(stderr=True)
    write = note if _State.shown else _write_nothing
    with _watched_compiler(write if not console.is_terminal else _write_nothing):
        if not (_State.shown and console.is_terminal):
            yield _Lines(write)
            return
        with _terminal_bars(console, speed_over_s) as progress:
            yield _Bars(progress)


class _Phases:
    """The phases of one sequence, which the log names once each."""

    def __init__(self, name: str) -> None:
        self._name, self._last = name, ""

    def label(self, phase: str, note: str = "") -> str:
        """Return the name of the sequence, with its phase and a note."""
        return printable(": ".join(filter(None, [self._name, phase, note])))

    def begins(self, phase: str) -> bool:
        """Return True if this phase is another one than before, and log it."""
        if phase == self._last:
            return False
        self._last = phase
        if phase:
            log_step(self.label(phase))
        return bool(phase)


class _Bars:
    """Bars on a terminal, one for each sequence."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress

    def track(self, name: str) -> Advance:
        phases = _Phases(name)
        task = self._progress.add_task(phases.label(""), total=None)

        def advance(done: int, total: int, phase: str = "", note: str = "") -> None:
            phases.begins(phase)
            self._progress.update(
                task, completed=done, total=total or None, description=phases.label(phase, note)
            )

        return advance


class _Lines:
    """A line for each phase, for each tenth of a long one, and for the end."""

    def __init__(self, write: Callable[[str], None]) -> None:
        self._write = write

    def track(self, name: str) -> Advance:
        phases, start_s = _Phases(name), time.perf_counter()
        last_s, last_share, ended = start_s, 0.0, False

        def advance(done: int, total: int, phase: str = "", note: str = "") -> None:
            nonlocal last_s, last_share, ended
            now_s, share = time.perf_counter(), done / total if total else 0.0
            begins, label = phases.begins(phase), phases.label(phase, note)
            ended = ended and not begins
            if share >= 1 and not ended:
                self._write(f"{label}: done after {_clock(now_s - start_s)}")
            elif begins:
                self._write(label)
            elif now_s - last_s >= _EVERY_S and share - last_share >= _EVERY_SHARE:
                self._write(f"{label}: {100 * share:.0f} % after {_clock(now_s - start_s)}")
            else:
                return
            last_s, last_share, ended = now_s, share, share >= 1

        return advance


def _terminal_bars(console: Console, speed_over_s: float) -> Progress:
    bar = BarColumn(_BAR_CHARACTERS)
    columns = (_Label(), bar, _Percentage(), _Times())
    return Progress(*columns, console=console, speed_estimate_period=speed_over_s, expand=True)


class _Label(ProgressColumn):
    """Name and phase, as long as there is room; "compiling" while kernels are compiled."""

    def __init__(self) -> None:
        super().__init__(Column(ratio=1, no_wrap=True, overflow="ellipsis"))

    def render(self, task: Task) -> Text:
        compiling = " (compiling)" if _State.compiling and not task.finished else ""
        return Text(task.description + compiling)


class _Percentage(ProgressColumn):
    """Share of the work; nothing while the total is unknown."""

    def __init__(self) -> None:
        super().__init__(Column(min_width=5, no_wrap=True, justify="right"))

    def render(self, task: Task) -> Text:
        return Text("" if task.total is None else f"{task.percentage:.0f} %")


class _Times(ProgressColumn):
    """Time since the start, and the estimated time to go."""

    def __init__(self) -> None:
        super().__init__(Column(min_width=17, no_wrap=True))

    def render(self, task: Task) -> Text:
        text = _clock(task.finished_time if task.finished else task.elapsed)
        if not task.finished and task.total is not None and task.time_remaining is not None:
            text += f", {_clock(task.time_remaining)} to go"
        return Text(text)


def _clock(seconds: float | None) -> str:
    minutes, rest = divmod(int(seconds or 0), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def _write_nothing(_: str) -> None:
    pass


@contextmanager
def _watched_compiler(write: Callable[[str], None]) -> Iterator[None]:
    """Say that kernels are compiled, which happens in the first run of a new version."""
    events: Any = sys.modules.get("numba.core.event")
    if events is None:
        yield
        return

    class Listener(events.Listener):  # type: ignore[misc]
        said = False

        def on_start(self, event: object) -> None:  # noqa: ARG002
            _State.compiling = True
            if not self.said:
                self.said = True
                log_step("compiling")
                write("compiling kernels, which later runs take from the cache")

        def on_end(self, event: object) -> None:  # noqa: ARG002
            _State.compiling = False

    with events.install_listener("numba:compile", Listener()):
        yield
