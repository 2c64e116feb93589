"""The renderer's thread: order, errors, and what happens at its end."""

import gc
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from typing import ClassVar

import mujoco
import numpy as np
import pytest

from sim.errors import RendererError
from sim.geometry.pinhole import Intrinsics, Pose
from sim.render import renderer_thread
from sim.render.filament import FilamentRenderer
from sim.render.renderer_thread import MESA_THREADS, RendererThread

MODEL = """<mujoco><worldbody><light type="directional" dir="0 0 -1" intensity="100"/>
<geom type="plane" size="5 5 .1"/></worldbody></mujoco>"""
LENS = Intrinsics(width=32, height=24, focal_px=30.0)


def test_what_is_rendered_in_the_thread_is_what_any_thread_renders() -> None:
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)

    def render(renderer: FilamentRenderer) -> object:
        renderer.update(data)
        return renderer.luminance(Pose(np.array([0.0, 0.0, 1.0])), (0, 0, 32, 24))

    with FilamentRenderer(model, LENS) as renderer:
        wanted = render(renderer)
    with RendererThread(model, LENS) as thread:
        found = thread.submit(render, thread.renderer).result()
    np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize(("chosen", "wanted"), [(None, "1"), ("3", "3")])
def test_the_context_uses_one_thread_of_mesa_unless_the_user_has_chosen(
    monkeypatch: pytest.MonkeyPatch, chosen: str | None, wanted: str
) -> None:
    seen = []

    class Noting(FakeRenderer):
        def __init__(self, *_: object) -> None:
            seen.append(os.environ.get(MESA_THREADS))

    monkeypatch.setattr(renderer_thread, "FilamentRenderer", Noting)
    monkeypatch.delenv(MESA_THREADS, raising=False)
    if chosen is not None:
        monkeypatch.setenv(MESA_THREADS, chosen)
    with RendererThread(mujoco.MjModel.from_xml_string(MODEL), LENS):
        assert os.environ.get(MESA_THREADS) == chosen  # other renderers are not affected
    assert seen == [wanted]


class FakeRenderer:
    """Stands for the renderer, and notes which threads make and close it."""

    threads: ClassVar[list[threading.Thread]] = []

    def __init__(self, *_: object) -> None:
        self.threads[:] = [threading.current_thread()]

    def close(self) -> None:
        self.threads.append(threading.current_thread())


@pytest.fixture
def thread(monkeypatch: pytest.MonkeyPatch) -> RendererThread:
    monkeypatch.setattr(renderer_thread, "FilamentRenderer", FakeRenderer)
    return RendererThread(mujoco.MjModel.from_xml_string(MODEL), LENS)


def test_calls_are_made_in_order_by_the_thread_that_made_the_renderer(
    thread: RendererThread,
) -> None:
    made: list[int] = []
    with thread:
        asked = [thread.submit(made.append, k) for k in range(20)]
        asked[-1].result()
        assert made == list(range(20))
        caller = thread.submit(threading.current_thread).result()
    assert FakeRenderer.threads == [caller, caller]


def test_errors_are_raised_where_the_result_is_waited_for(thread: RendererThread) -> None:
    with thread, pytest.raises(ZeroDivisionError):
        thread.submit(lambda: 1 / 0).result()


def test_at_the_end_calls_that_wait_are_cancelled(thread: RendererThread) -> None:
    with thread:
        thread.submit(time.sleep, 0.05)
        waiting = thread.submit(pytest.fail, "called after the end")
    with pytest.raises(CancelledError):
        waiting.result()
    assert len(FakeRenderer.threads) == 2


def test_a_renderer_that_cannot_be_made_leaves_no_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise RendererError("no device")

    monkeypatch.setattr(renderer_thread, "FilamentRenderer", fail)
    before = threading.active_count()
    with pytest.raises(RendererError, match="no device"):
        RendererThread(mujoco.MjModel.from_xml_string(MODEL), LENS)
    assert threading.active_count() == before


def forgotten(thread: RendererThread) -> None:
    """Leave an open context to the garbage collector, in a reference cycle."""

    def opened() -> Iterator[RendererThread]:
        with thread:
            yield thread

    iterator = opened()
    next(iterator)
    cycle: list[object] = [iterator]
    cycle.append(cycle)


def test_the_garbage_collector_may_end_the_context(thread: RendererThread) -> None:
    forgotten(thread)
    del thread
    collector = threading.Thread(target=gc.collect, daemon=True)
    collector.start()
    collector.join(timeout=20)
    assert not collector.is_alive()


def test_a_renderer_that_is_garbage_is_closed_by_the_thread_that_made_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(renderer_thread, "FilamentRenderer", FakeRenderer)
    forgotten(RendererThread(mujoco.MjModel.from_xml_string(MODEL), LENS))
    gc.collect()
    made, closed = FakeRenderer.threads
    assert made is closed


def test_the_garbage_collector_may_end_the_context_in_the_thread_itself(
    thread: RendererThread,
) -> None:
    forgotten(thread)
    thread.submit(gc.collect).result(timeout=20)
    assert FakeRenderer.threads[0] is FakeRenderer.threads[1]


@pytest.mark.parametrize(
    "ending",
    ["", "raise ValueError('of the user')", "samples.close()", "keep_renderer(); list(samples)"],
)
def test_python_may_end_while_samples_are_unread(ending: str) -> None:
    program = f"""
from sim import Crossing, CrossingConfig
from sim.render.kept_renderer import keep_renderer
samples = Crossing(CrossingConfig(omega_rad_s=8.0, step_px=8.0, supersample=1)).samples()
next(samples)
print("read", flush=True)
{ending}
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=False
    )
    assert (done.returncode, done.stdout) == (1 if "raise" in ending else 0, "read\n"), done.stderr
    assert "terminating" not in done.stderr
