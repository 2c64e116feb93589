import numpy as np
import pytest

from scenarios.envelope.sway import make_sway


@pytest.mark.parametrize("seed", range(5))
def test_a_sway_keeps_to_what_was_asked(seed: int) -> None:
    sway = make_sway((1.5, 0.5), (1.0, 12.0), np.random.default_rng(seed))
    times_s = np.linspace(0, 200, 200_001)
    way_px = sway.at(times_s)
    np.testing.assert_allclose(np.sqrt((way_px**2).mean(axis=0)), (1.5, 0.5), rtol=0.05)
    speed_px_s = np.hypot(*np.diff(way_px, axis=0).T) / np.diff(times_s)
    assert speed_px_s.max() <= sway.fastest_px_s
    assert abs(way_px).max() <= sway.farthest_px
    assert 1.0 <= sway.hz.min() <= sway.hz.max() <= 12.0


def test_slow_waves_are_the_large_ones() -> None:
    sway = make_sway((1.0, 1.0), (0.5, 4.0), np.random.default_rng(0))
    for hz, amplitude in zip(sway.hz, sway.amplitude_px, strict=True):
        np.testing.assert_allclose(hz * amplitude, (hz * amplitude)[0])
