import math
from itertools import pairwise
from typing import Any

import pytest

from emulator import Bias, Biases, SensorConfig, SensorConfigError, with_biases
from emulator.biases import COARSE_PA


def test_currents_match_the_makers_table() -> None:
    assert Bias(7, 255).current_a == pytest.approx(24.8e-6)
    assert Bias(4, 39).current_a == pytest.approx(48_437e-12 * 39 / 255)
    assert Bias(4, 0).current_a == Bias(4, 1).current_a
    steps = [b / a for a, b in pairwise(COARSE_PA)]
    assert steps == pytest.approx([8.0] * 7, rel=0.07)


def test_thresholds_are_proportional_to_the_logarithm_of_the_ratio() -> None:
    ten, hundred = (Biases(diff=Bias(3, 10), on=Bias(3, 10 * n)) for n in (5, 25))
    assert hundred.theta_on == pytest.approx(2.0 * ten.theta_on)
    assert ten.theta_on == pytest.approx(math.log(5.0) / 14.0)
    down = Biases(diff=Bias(3, 250), off=Bias(3, 10), on=Bias(7, 255))
    assert down.theta_off == pytest.approx(math.log(25.0) / 14.0)


def test_the_makers_defaults_give_a_refractory_period_of_3_us() -> None:
    biases = Biases()
    assert round(biases.refractory_us) == 3
    assert biases.follower_hz == pytest.approx(286.0, rel=0.01)
    assert (biases.theta_on, biases.theta_off) == pytest.approx((0.283, 0.262), abs=1e-3)
    assert Biases.preset("davis346") == biases
    assert Biases.preset("davis240").off == Bias(4, 0)


def test_a_sensor_takes_its_parameters_from_the_biases() -> None:
    biases = Biases(refractory=Bias(2, 100), follower=Bias(2, 58))
    config = with_biases(SensorConfig(width=20), biases)
    assert config.width == 20
    assert config.theta_on == biases.theta_on
    assert config.theta_off == biases.theta_off
    assert config.follower_hz == biases.follower_hz
    assert config.refractory_us == round(16e-15 / (756e-12 * 100 / 255) * 1e6) == 54


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Bias(8, 0), "coarse is 8. Allowed is a whole number from 0 to 7"),
        (lambda: Bias(0, 256), "fine is 256"),
        (lambda: Bias(0, 1.5), "fine is 1.5"),  # type: ignore[arg-type]
        (lambda: Biases(on=Bias(4, 39)), "theta_on is 0.0"),
        (lambda: Biases(off=Bias(5, 39)), "theta_off is -0"),
        (lambda: Biases.preset("davis128"), "biases is 'davis128'. Allowed is one of davis346"),
        (lambda: with_biases(SensorConfig(), None), "biases are None. Allowed is a Biases"),  # type: ignore[arg-type]
        (lambda: with_biases(None, Biases()), "sensor is None. Allowed is a SensorConfig"),  # type: ignore[arg-type]
        (lambda: Biases(on=(6, 200)), r"bias on is \(6, 200\). Allowed is a Bias"),  # type: ignore[arg-type]
    ],
)
def test_invalid_biases_are_refused(make: Any, words: str) -> None:
    with pytest.raises(SensorConfigError, match=words):
        make()


def test_the_bandwidth_of_the_photoreceptor_is_proportional_to_its_bias() -> None:
    default = with_biases(SensorConfig(), Biases())
    assert default.bandwidth_limit_hz == SensorConfig().bandwidth_limit_hz == 3000.0
    half = with_biases(SensorConfig(), Biases(photoreceptor=Bias(2, 29)))
    assert half.bandwidth_limit_hz == pytest.approx(1500.0)
