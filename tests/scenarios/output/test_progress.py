"""Progress on a terminal and elsewhere."""

import io
import sys
import time

import pytest
from rich.progress import Progress

from scenarios.output import progress as module
from scenarios.output.progress import progress_bar, show_progress
from scenarios.output.streams import SafeConsole


def test_elsewhere_each_phase_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar() as bars:
        advance = bars.track("night, moving left")
        advance(0, 0, "building the street")
        for t_us in range(0, 101, 10):
            advance(t_us, 100, "crossing")
        advance(0, 0, "writing")
        advance(100, 100)
    assert capsys.readouterr().err.splitlines() == [
        "flybench: night, moving left: building the street",
        "flybench: night, moving left: crossing",
        "flybench: night, moving left: crossing: done after 0:00",
        "flybench: night, moving left: writing",
        "flybench: night, moving left: done after 0:00",
    ]


@pytest.mark.parametrize(("unit", "shown"), [("", ""), (" MB", "10 MB: ")], ids=["plain", "note"])
def test_elsewhere_a_long_phase_has_a_line_for_each_tenth(
    unit: str, shown: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = iter(range(1000))
    monkeypatch.setattr(time, "perf_counter", lambda: float(next(now_s)))
    with progress_bar() as bars:
        advance = bars.track("study")
        for done in range(1, 51):
            advance(done, 100, note=f"{done}{unit}" if unit else "")
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == f"flybench: study: {shown}10 % after 0:10"
    assert len(lines) == 4


def test_a_name_from_a_file_cannot_command_the_terminal(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with progress_bar() as bars:
        bars.track("[/red]\x1b[2J")(1, 2, "3.5 MB")
    assert capsys.readouterr().err == "flybench: [/red]\\x1b[2J: 3.5 MB\n"


def test_quiet_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with show_progress(False), progress_bar() as bars:
        bars.track("name")(1, 1, "phase")
    with progress_bar() as bars:
        bars.track("name")(0, 0, "phase")
    assert capsys.readouterr().err == "flybench: name: phase\n"


@pytest.mark.parametrize("width", [60, 80, 120])
def test_on_a_terminal_everything_has_room(width: int) -> None:
    console = SafeConsole(width=width)
    console.file = io.StringIO()
    console._force_terminal = True
    with module._terminal_bars(console, 30.0) as progress:
        advance = module._Bars(progress).track("night, 1.07 rad/s, moving left")
        advance(0, 0, "building the street")
        advance(30, 100, "crossing")
        shown = _text(progress, width)
    assert "30 %" in shown
    assert "0:00" in shown
    assert "night, 1.07" in shown
    assert ("crossing" in shown) == (width > 60)  # the name is shortened then
    assert len(shown.rstrip("\n")) <= width


def _text(progress: Progress, width: int) -> str:
    console = SafeConsole(width=width)
    console.file = io.StringIO()
    console.print(progress.get_renderable())
    return str(console.file.getvalue())


def test_the_compiler_is_named_while_it_works(capsys: pytest.CaptureFixture[str]) -> None:
    import numba

    assert "numba.core.event" in sys.modules
    with progress_bar() as bars:
        bars.track("run")
        numba.njit(lambda number: number + 1)(1)
        numba.njit(lambda number: number + 2)(1)
    assert capsys.readouterr().err.count("compiling") == 1
    assert not module._State.compiling
