"""Counting Filament's entities: a process never runs out of them without a word."""

import mujoco
import numpy as np
import pytest

from sim.errors import RendererError
from sim.geometry.pinhole import Intrinsics, Pose
from sim.render import entities
from sim.render.entities import reserve_entities
from sim.render.filament import FilamentRenderer

LENS = Intrinsics(width=8, height=6, focal_px=8.0)
EYE = Pose(np.array([0.0, 0.0, 1.0]))
MODEL = mujoco.MjModel.from_xml_string(
    """<mujoco><worldbody><light type="directional" dir="0 0 -1" intensity="100"/>
    <geom type="plane" size="5 5 .1"/><geom type="box" size="1 1 1"/>
    <geom type="cylinder" size="1 1"/><site type="capsule" size="1 1"/></worldbody></mujoco>"""
)
COUNT = 2 * (2 + 1 + 3 + 3)


@pytest.fixture(autouse=True)
def _a_process_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(entities, "_used", [])
    monkeypatch.setattr(entities, "MAX_ENTITIES", 3 * COUNT)


def draw(renderer: FilamentRenderer) -> None:
    renderer.luminance(EYE, (0, 0, 8, 6), supersample=1)


def draw_and_close() -> None:
    with FilamentRenderer(MODEL, LENS) as renderer:
        draw(renderer)


def test_parts_of_geoms_and_sites_are_counted_in_both_scenes() -> None:
    assert reserve_entities(MODEL).count == COUNT


def test_any_number_of_renderers_may_follow_each_other() -> None:
    for _ in range(6):
        draw_and_close()


def test_an_idle_renderer_ends_in_an_error_until_it_draws_or_closes() -> None:
    with FilamentRenderer(MODEL, LENS) as idle:
        draw_and_close()
        draw_and_close()
        with pytest.raises(
            RendererError, match=f"needs {COUNT} entities of Filament, and .*renderers: 1"
        ):
            draw_and_close()
        draw(idle)
        draw_and_close()
    draw_and_close()


def test_a_renderer_that_was_dropped_counts_as_closed() -> None:
    for _ in range(3):
        draw(FilamentRenderer(MODEL, LENS))
    draw_and_close()
