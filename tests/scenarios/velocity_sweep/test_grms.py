"""GRMS against velocity: rank correlation, figure, and the fly's GRMS on synthetic stimuli."""

from pathlib import Path

import pytest

from detector.metrics import grms as grms_of
from scenarios.envelope.measure import measure_all
from scenarios.envelope.stimulus import Stimulus, Surface
from scenarios.pipeline.repeats import run_repeats
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_crossing
from scenarios.velocity_sweep.grms import draw_grms, spearman, spearman_by_seed
from sim import CrossingConfig, Lighting
from sim.config import PAPER_OMEGA_RAD_S

SPEEDS_PX_S = (300.0, 400.0, 500.0, 600.0)
"""Speeds in the ratio of the paper's."""
SEEDS = 10


def rows(lighting: str, seed: int, *grms: float | None) -> list[dict[str, object]]:
    return [
        {"lighting": lighting, "seed": seed, "omega_rad_s": float(n), "grms": value}
        for n, value in enumerate(grms)
    ]


@pytest.mark.parametrize(
    ("grms", "rank"),
    [
        ((1.0, 2.0, 3.0, 4.0), 1.0),
        ((4.0, 3.0, 2.0, 1.0), -1.0),
        ((1.0, 3.0, 2.0, 4.0), 0.8),
        ((1.0, 1.0, 1.0, 1.0), None),
        ((1.0, None, 2.0, 3.0), None),
    ],
)
def test_rank_correlation(grms: tuple[float | None, ...], rank: float | None) -> None:
    assert spearman((1.0, 2.0, 3.0, 4.0), grms) == (None if rank is None else pytest.approx(rank))


def test_one_velocity_has_no_rank_correlation() -> None:
    assert spearman((1.0,), (3.0,)) is None


def test_there_is_one_correlation_per_lighting_and_seed() -> None:
    days = [*rows("day", 0, 1, 2), *rows("day", 1, 2, 1)]
    found = spearman_by_seed([*days, *rows("night", 0, 1, 3)])
    assert found == {"day": {"0": 1.0, "1": -1.0}, "night": {"0": 1.0}}


def test_the_figure_counts_the_seeds_whose_grms_rises(tmp_path: Path) -> None:
    some = [*rows("day", 0, 1, 2, 3), *rows("day", 1, 3, 2, 4), *rows("night", 0, 1, 2, None)]
    draw_grms(tmp_path / "grms", some, method="fly")
    svg = (tmp_path / "grms.svg").read_text()
    assert "day: rises throughout in 1 of 2 seeds" in svg
    assert "night: rises throughout in 0 of 1 seeds" in svg


def test_the_flys_grms_rises_with_speed() -> None:
    cars = [
        Stimulus(speed_px_s=speed, noise_hz=0.5, seed=k, surface=Surface.SALOON, length_px=200)
        for k in range(SEEDS)
        for speed in SPEEDS_PX_S
    ]
    values = [row["grms"] for row in measure_all(cars, ["fly"], jobs=-1)[0]]
    by_seed = [values[n : n + 4] for n in range(0, len(values), 4)]
    assert sum(spearman(SPEEDS_PX_S, grms) == 1.0 for grms in by_seed) >= 9


@pytest.mark.parametrize("lighting", [Lighting.DAY, Lighting.NIGHT])
def test_the_flys_grms_is_higher_at_the_papers_fastest_than_at_its_slowest(
    lighting: Lighting,
) -> None:
    omegas = PAPER_OMEGA_RAD_S[lighting]
    slowest, fastest = (rendered_grms(lighting, omega) for omega in (min(omegas), max(omegas)))
    assert all(fast > slow > 0 for slow, fast in zip(slowest, fastest, strict=True))


def rendered_grms(lighting: Lighting, omega_rad_s: float) -> list[float]:
    """Return GRMS for three seeds, from one coarse rendering."""
    crossing = CrossingConfig(
        lighting=lighting, omega_rad_s=omega_rad_s, step_px=8.0, supersample=1
    )
    config = RunConfig(crossing)
    by_seed, track = run_repeats(config, make_crossing(config).samples(), range(3))
    return [grms_of(estimates, crossing_us=track.in_view_us) or 0.0 for estimates in by_seed]
