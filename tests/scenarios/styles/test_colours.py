"""Colours of polarity and methods: visible on every background, and different for colour-blind
readers too."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest

from scenarios.output.colours import OFF, ON, rgb_of
from scenarios.pipeline.registry import DETECTORS

COLOURS = {"ON": ON, "OFF": OFF} | {m: rgb_of(e.colour) for m, e in DETECTORS.items()}
WHITE, DARK = (255, 255, 255), (13, 17, 23)
TO_XYZ = np.array(
    [[0.4125, 0.3576, 0.1804], [0.2127, 0.7152, 0.0722], [0.0193, 0.1192, 0.9503]]
)  # IEC 61966-2-1
DEUTERANOPIA = [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]
PROTANOPIA = [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]
"""Machado, Oliveira and Fernandes 2009, table 1, severity 1.0."""


def linear(rgb: Any) -> Any:
    share = np.asarray(rgb) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(light: Any) -> Any:
    x, y, z = np.cbrt((TO_XYZ @ light) / TO_XYZ.sum(axis=1))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def contrast(one: Any, other: Any) -> float:
    low, high = sorted(float(TO_XYZ[1] @ linear(rgb)) for rgb in (one, other))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("name", COLOURS)
def test_a_colour_is_visible_on_white_and_on_a_dark_page(name: str) -> None:
    assert contrast(COLOURS[name], WHITE) >= 3.0
    assert contrast(COLOURS[name], DARK) >= 3.0


def test_colours_differ_for_colour_blind_readers_too() -> None:
    for sight in (DEUTERANOPIA, PROTANOPIA):
        seen = {n: lab(np.clip(sight @ linear(rgb), 0, 1)) for n, rgb in COLOURS.items()}
        for one, other in combinations(seen, 2):
            assert np.linalg.norm(seen[one] - seen[other]) > 12.0, (one, other)
    assert np.linalg.norm(lab(linear(ON)) - lab(linear(OFF))) > 100.0
