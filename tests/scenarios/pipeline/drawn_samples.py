"""A synthetic sequence of luminance samples, for tests without rendering."""

from collections.abc import Iterator

import numpy as np

from sim import Crossing, CrossingConfig, Sample
from sim.truth.probe import TruthProbe
from tests.sim.body_labels import target_body_labels

CROSSING = Crossing(CrossingConfig())
SAMPLES, PERIOD_US = 100, 1_500


def bar_samples() -> Iterator[Sample]:
    """Yield samples of a bright bar that moves to the right for 150 ms."""
    probe = TruthProbe(CROSSING.scene, CROSSING.intrinsics)
    for k in range(SAMPLES):
        luminance = np.full((260, 346), 100.0, np.float32)
        mask = np.zeros((260, 346), np.bool_)
        mask[100:160, 2 * k : 2 * k + 60] = True
        luminance[mask] = 300.0
        t_us = PERIOD_US * k
        truth = probe.measure(
            t_us, CROSSING.seconds(t_us), target_body_labels(mask, CROSSING.scene)
        )
        yield Sample(t_us, luminance, truth, changed=(0, 0, 346, 260))
