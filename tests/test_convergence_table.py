"""The tool that prints how well events converge: its combinations, and what it compares."""

from dataclasses import replace

import pytest

from scenarios.convergence.measure import piece_times_us
from sim import Crossing, CrossingConfig, Quality
from tools.convergence_table import (
    DEFAULT,
    FULL,
    GROUPS,
    PIECE_PX,
    REFERENCE,
    combinations,
    frames_with_midpoints,
)


def test_there_are_65_different_combinations() -> None:
    found = [config for group in GROUPS for config in combinations(group)]
    assert len(found) == len(set(found)) == 65


def test_all_renderings_but_a_draft_end_at_the_same_time() -> None:
    crossing = Crossing(CrossingConfig())
    ends = {piece_times_us(crossing, PIECE_PX, r.step_px)[-1] for r in (REFERENCE, FULL, DEFAULT)}
    assert len(ends) == 1


@pytest.mark.parametrize(("quality", "steps"), [(Quality.FINE, 5), (Quality.DRAFT, 3)])
def test_samples_in_between_halve_the_steps(quality: Quality, steps: int) -> None:
    config = replace(CrossingConfig(supersample=1), quality=quality)
    times_us = [t_us for t_us, _ in frames_with_midpoints(config)]
    rendered = piece_times_us(Crossing(config), PIECE_PX, config.drawn_step_px)
    assert len(rendered) == steps + 1
    assert times_us[::2] == rendered
    assert len(times_us) == 2 * steps + 1
