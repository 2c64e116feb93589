"""Random oscillations."""

import numpy as np
import pytest

from scenarios.envelope.oscillation import random_oscillation


@pytest.mark.parametrize("seed", range(5))
def test_an_oscillation_has_the_given_amplitude_and_band(seed: int) -> None:
    motion = random_oscillation((1.5, 0.5), (1.0, 12.0), np.random.default_rng(seed))
    times_s = np.linspace(0, 200, 200_001)
    displacement_px = motion.at(times_s)
    np.testing.assert_allclose(np.sqrt((displacement_px**2).mean(axis=0)), (1.5, 0.5), rtol=0.05)
    speed_px_s = np.hypot(*np.diff(displacement_px, axis=0).T) / np.diff(times_s)
    assert speed_px_s.max() <= motion.max_speed_px_s
    assert abs(displacement_px).max() <= motion.max_displacement_px
    assert 1.0 <= motion.hz.min() <= motion.hz.max() <= 12.0


def test_amplitudes_are_proportional_to_the_period() -> None:
    motion = random_oscillation((1.0, 1.0), (0.5, 4.0), np.random.default_rng(0))
    for hz, amplitude in zip(motion.hz, motion.amplitude_px, strict=True):
        np.testing.assert_allclose(hz * amplitude, (hz * amplitude)[0])
