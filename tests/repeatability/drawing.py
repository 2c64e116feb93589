"""Scenarios to draw, and digests of what is drawn."""

from __future__ import annotations

import hashlib
from typing import Any
from unittest.mock import patch

import numpy as np

from sim import (
    Crossing,
    CrossingConfig,
    Direction,
    Distractors,
    Lighting,
    Pavement,
    RelativeDirection,
    VehicleKind,
)
from sim.config import PAPER_OMEGA_RAD_S
from sim.keyframes import reprojection
from sim.keyframes.plan import plan_keyframes
from sim.render.filament import FilamentRenderer

RANDOM_COUNT = 20
SEED = 2026


def scenarios() -> dict[str, CrossingConfig]:
    """Return the paper's eight sequences and random ones with distractors, by name."""
    paper = {
        f"{lighting}-{omega:g}": CrossingConfig(lighting=lighting, omega_rad_s=omega)
        for lighting, omegas in PAPER_OMEGA_RAD_S.items()
        for omega in omegas
    }
    known = {  # each drew one of two variants before the order of drawing was fixed
        "day-2.7-left": CrossingConfig(omega_rad_s=2.7, direction=Direction.LEFT),
        "day-1.9-shake": CrossingConfig(
            omega_rad_s=1.9, distractors=Distractors(shake_rms_deg=0.1)
        ),
    }
    rng = np.random.default_rng(SEED)
    drawn = {f"random-{k}": _random(rng) for k in range(RANDOM_COUNT)}
    return paper | known | drawn


def drawing_digest(config: CrossingConfig) -> str:
    """Return the SHA-256 digest of every image that is rendered for a crossing.

    These are the layers of the background and every keyframe.
    """
    images, times = hashlib.sha256(), set[int]()

    def render_image(self: FilamentRenderer, *args: Any, **options: Any) -> Any:
        image = subpixel_luminance(self, *args, **options)
        images.update(image.tobytes())
        return image

    def plan(*args: Any, **options: Any) -> Any:
        keyframes, affected = plan_keyframes(*args, **options)
        times.update(t_us for planned in keyframes.values() for t_us in planned)
        return keyframes, affected

    subpixel_luminance = FilamentRenderer.subpixel_luminance
    with (
        patch.object(FilamentRenderer, "subpixel_luminance", render_image),
        patch.object(reprojection, "plan_keyframes", plan),
    ):
        crossing = Crossing(config)
        with crossing.keyframe_renderer(crossing.times_us()) as render:
            for t_us in sorted(times):
                render(t_us)
    return images.hexdigest()


def _random(rng: np.random.Generator) -> CrossingConfig:
    """Return a random scenario with at least one distractor."""
    lighting = Lighting(rng.choice(list(Lighting)))
    directions = [d for d in Direction if d is not Direction.NONE]
    moves = RelativeDirection(rng.choice([RelativeDirection.SAME, RelativeDirection.OPPOSITE]))
    still = RelativeDirection.NONE
    names = rng.choice(
        ["wind", "vehicle", "pedestrian", "shake", "flicker"], rng.integers(1, 4), replace=False
    )
    return CrossingConfig(
        lighting=lighting,
        omega_rad_s=round(float(rng.uniform(1.0, 3.5)), 2),
        direction=Direction(rng.choice(directions)),
        vehicle=VehicleKind(rng.choice(list(VehicleKind))),
        paint_reflectance=round(float(rng.uniform(0.04, 0.8)), 2),
        street_seed=int(rng.integers(1000)),
        distractors=Distractors(
            wind_grade=int(rng.integers(2, 7)) if "wind" in names else 0,
            far_vehicle=moves if "vehicle" in names else still,
            far_vehicle_kind=VehicleKind(rng.choice(list(VehicleKind))),
            pedestrian=moves if "pedestrian" in names else still,
            pedestrian_pavement=Pavement.FAR,
            shake_rms_deg=0.1 if "shake" in names else 0.0,
            flicker_hz=100 if "flicker" in names else 0,
            seed=int(rng.integers(1000)),
        ),
    )
