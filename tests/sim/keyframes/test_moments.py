"""The state at a time is that of its time alone, whatever was asked for before."""

from typing import Any

import mujoco
import numpy as np
import pytest

from sim.config import CrossingConfig, Lighting
from sim.distractors import Distractors, RelativeDirection
from sim.geometry.pinhole import Intrinsics, project
from sim.geometry.rigid_transform import body_poses
from sim.keyframes.moments import Moment, Moments
from sim.keyframes.mover_visibility import MoverRaster, split_into_parts
from sim.motion.computed_ahead import BLOCK, ComputedAhead
from sim.scene.lamp_flicker import FlickeringLamps
from sim.scene.scene import Scene, build_scene
from sim.shadows.shadows_and_beams import AffectedAreaFinder

LENS = Intrinsics()
EVERYTHING = Distractors(
    wind_grade=4,
    far_vehicle=RelativeDirection.OPPOSITE,
    pedestrian=RelativeDirection.SAME,
    flicker_hz=100,
)
STEP_US = 31_300
SUPERSAMPLE = 2


def seconds(t_us: int) -> float:
    return (t_us - BLOCK * STEP_US) * 1e-6


def moments_of(**options: Any) -> tuple[Scene, AffectedAreaFinder, Moments]:
    scene = build_scene(CrossingConfig(**options))
    data = mujoco.MjData(scene.model)
    scene.place(data, 0.0)
    areas = AffectedAreaFinder(scene.model, data, scene.objects, scene.pose, LENS)
    movers = scene.soup.of_bodies([int(b) for o in scene.objects for b in o.bodies])
    parts = split_into_parts(scene.model, scene.objects)
    raster = MoverRaster(movers, parts, scene.pose, LENS, supersample=SUPERSAMPLE)
    lamps = FlickeringLamps(scene.flickering_lights, scene.flickering_materials)
    flickering = lamps if scene.flicker else None
    return scene, areas, Moments(scene, data, seconds, raster, areas, flickering)


def flat(moment: Moment) -> list[Any]:
    """Return everything that a state holds."""
    values = moment._asdict() | moment.affected._asdict()
    return [values[name] for name in values if name != "affected"]


def test_states_found_in_blocks_are_those_found_one_by_one() -> None:
    _, _, moments = moments_of(lighting=Lighting.NIGHT, distractors=EVERYTHING)
    times_us = [k * STEP_US for k in range(2 * BLOCK + 3)]
    ahead = ComputedAhead(moments.at, times_us)
    found = [ahead.at(t_us) for t_us in times_us]
    for t_us, moment in reversed(list(zip(times_us, found, strict=True))):
        for one, other in zip(flat(moment), flat(moments.at(t_us)), strict=True):
            np.testing.assert_array_equal(one, other)
    assert len({str(moment.drawn) for moment in found}) > BLOCK
    assert len({moment.flicker for moment in found}) > 1


def test_the_changed_rectangles_hold_objects_shadows_and_beams() -> None:
    scene, areas, moments = moments_of(lighting=Lighting.NIGHT, distractors=EVERYTHING)
    data = mujoco.MjData(scene.model)
    for t_us in range(0, 2 * BLOCK * STEP_US, 5 * STEP_US):
        now = moments.at(t_us)
        scene.place(data, seconds(t_us))
        corners = now.triangles[..., :2].reshape(-1, 2) / SUPERSAMPLE
        for x0, y0, x1, y1 in [*now.drawn, *areas.find(data).rectangles]:
            holders = [r for r in now.changed if r[0] <= x0 and r[1] <= y0 and x1 <= r[2]]
            assert sum(y1 <= r[3] for r in holders) == 1
        inside = (corners >= 0).all(axis=1) & (corners < (LENS.width, LENS.height)).all(axis=1)
        for x, y in corners[inside][::20]:
            assert any(x0 <= x <= x1 and y0 <= y <= y1 for x0, y0, x1, y1 in now.changed)
        np.testing.assert_array_equal(now.poses, body_poses(data))
        points = data.xpos[scene.target.bodies]
        pixels, depth = project(points, scene.pose, LENS)
        in_camera = now.views[scene.target.bodies][:, :, 3]
        np.testing.assert_allclose(in_camera[:, 2], depth)
        across = LENS.width / 2 + LENS.focal_px * in_camera[:, 0] / depth
        np.testing.assert_allclose(across, pixels[:, 0])


@pytest.mark.parametrize("flickers", [True, False])
def test_gains_of_lamps_on_the_mains_flicker(flickers: bool) -> None:
    """The first layer is steady, and the last one, if the lamps flicker, is theirs."""
    extra = Distractors(flicker_hz=100 * flickers, flicker_depth=0.5)
    scene, areas, moments = moments_of(lighting=Lighting.NIGHT, distractors=extra)
    mains = np.isin(areas.shadow_lights, scene.flickering_lights)
    assert mains.any()
    for t_us in (0, 1000, 3500):
        factor = scene.flicker_factor(seconds(t_us))
        assert (factor != 1.0) == flickers
        wanted = [1.0, *np.where(mains, factor, 1.0), *[factor] * flickers]
        assert moments.at(t_us).gains.tolist() == wanted
