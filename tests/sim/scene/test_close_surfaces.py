"""Parts of different materials never lie in nearly the same plane, where both could be seen."""

from __future__ import annotations

from collections import Counter
from typing import Any

import mujoco
import numpy as np
import pytest

from sim import Crossing, CrossingConfig, Distractors, RelativeDirection, VehicleKind
from sim.geometry.pinhole import NEAR_M
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster.scan_conversion import NO_LABEL, empty_buffer, project_triangles, rasterise
from sim.raster.triangles import triangle_soup, unit_normals

MARGIN_M = 1e-3
PARALLEL = np.cos(np.radians(2.0))


def close_parts(crossing: Crossing, share: float) -> Counter[tuple[str, str]]:
    """Count pixels where the surface seen and one behind it are parallel and less than 1 mm apart.

    Args:
        crossing: the crossing.
        share: share of the sequence that has passed.

    Returns:
        Number of pixels by the names of both parts.
    """
    model, lens = crossing.scene.model, crossing.intrinsics
    data, soup = mujoco.MjData(model), triangle_soup(model)
    crossing.scene.place(data, crossing.seconds(int(share * crossing.duration_us)))
    poses = compose_transforms(body_poses(data), crossing.scene.pose.world_to_camera)
    in_camera = soup.transformed(poses)
    normals = unit_normals(in_camera)
    centre = lens.width / 2, lens.height / 2
    triangles, source = project_triangles(in_camera, lens.focal_px, *centre, NEAR_M)
    geom = soup.geom[source]
    nearest = _rasterised(triangles, source, (lens.height, lens.width))
    found: Counter[tuple[str, str]] = Counter()
    for behind in range(model.ngeom):
        mine = geom == behind
        depth, label = _rasterised(triangles[mine], source[mine], nearest[0].shape)
        both = (label != NO_LABEL) & (nearest[1] != label) & (depth - nearest[0] < MARGIN_M)
        for front, back in zip(nearest[1][both], label[both], strict=True):
            parallel = normals[front] @ normals[back] > PARALLEL
            if parallel and not _same_material(model, int(soup.geom[front]), behind):
                found[_name(model, int(soup.geom[front])), _name(model, behind)] += 1
    return found


def _rasterised(triangles: Any, labels: Any, shape: tuple[int, int]) -> tuple[Any, Any]:
    """Return depth [m] and label of the nearest triangle at each pixel."""
    nearness, label = empty_buffer(*shape)
    rasterise(np.ascontiguousarray(triangles), labels, 0, 0, nearness, label, True)
    return 1 / np.maximum(nearness, 1e-6), label


def _same_material(model: Any, a: int, b: int) -> bool:
    same_colour = (model.geom_rgba[a] == model.geom_rgba[b]).all()
    return bool(model.geom_matid[a] == model.geom_matid[b] and same_colour)


def _name(model: Any, geom: int) -> str:
    body = model.body(model.geom_bodyid[geom]).name
    return f"{body}, geom {geom}, {model.mat(model.geom_matid[geom]).name}"


@pytest.mark.parametrize("kind", VehicleKind)
def test_no_parallel_surfaces_lie_within_a_millimetre(kind: VehicleKind) -> None:
    others = Distractors(
        far_vehicle=RelativeDirection.OPPOSITE,
        far_vehicle_kind=kind,
        pedestrian=RelativeDirection.SAME,
    )
    crossing = Crossing(CrossingConfig(vehicle=kind, distractors=others))
    found = sum((close_parts(crossing, share) for share in (0.4, 0.5, 0.6)), Counter())
    assert not found


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_facade_has_parallel_surfaces_within_a_millimetre(seed: int) -> None:
    assert not close_parts(Crossing(CrossingConfig(street_seed=seed)), 0.0)


def test_a_sheet_of_another_material_on_a_wall_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    crossing = Crossing(CrossingConfig())
    monkeypatch.setattr(f"{__name__}.MARGIN_M", 0.02)  # window bars stand out by 13 mm
    assert close_parts(crossing, 0.0)
