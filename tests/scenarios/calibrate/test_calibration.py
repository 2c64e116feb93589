"""Parameters of three different sensors and the default, from recordings of a moving texture."""

import pytest

from emulator import SensorConfig
from emulator.characterisation import Section
from scenarios.calibrate import calibration as calibration_module
from scenarios.calibrate.calibration import Calibration, calibrate
from scenarios.calibrate.fit import Fit, Parameter, unknown
from scenarios.calibrate.recording import from_aps
from tests.scenarios.calibrate.moving_texture import HEIGHT, WIDTH, recorded

SENSORS = {
    "fast follower": SensorConfig(
        width=WIDTH, height=HEIGHT, noise_sigma=0.05, follower_hz=1000.0, refractory_us=200
    ),
    "sensitive": SensorConfig(
        width=WIDTH,
        height=HEIGHT,
        theta_on=0.15,
        theta_off=0.12,
        theta_mismatch=0.015,
        refractory_us=270,
        follower_hz=1000.0,
        noise_sigma=0.025,
        leak_hz=0.2,
    ),
    "dull, fast and noisy": SensorConfig(
        width=WIDTH,
        height=HEIGHT,
        theta_on=0.45,
        theta_off=0.40,
        theta_mismatch=0.04,
        refractory_us=150,
        follower_hz=0.0,
        bandwidth_hz_per_lux=200.0,
        bandwidth_limit_hz=2000.0,
        noise_sigma=0.08,
        leak_hz=0.1,
    ),
    "the default": SensorConfig(width=WIDTH, height=HEIGHT),
}
SLOW_FOLLOWER_HZ = 500.0
"""Below this cutoff, the time from a reset to the next threshold lengthens all intervals."""


def start_for(sensor: SensorConfig) -> SensorConfig:
    """The default sensor, with the limits of the bandwidth, which a recording does not tell."""
    return SensorConfig(
        follower_hz=sensor.follower_hz, bandwidth_limit_hz=sensor.bandwidth_limit_hz
    )


@pytest.fixture(scope="module", params=SENSORS, ids=str)
def both(request: pytest.FixtureRequest) -> tuple[SensorConfig, Calibration]:
    sensor = SENSORS[request.param]
    events, frames = recorded(sensor)
    recording = from_aps(events, frames, sensor.aps, name="made")
    return sensor, calibrate(recording, start_for(sensor))


@pytest.mark.parametrize(
    ("name", "within"),
    [
        ("theta_on", 0.07),
        ("theta_off", 0.07),
        ("theta_mismatch", 0.25),
        ("refractory_us", 0.10),
        ("noise_sigma", 0.20),
        ("leak_hz", 0.20),
        ("bandwidth_hz_per_lux", 0.40),
    ],
)
def test_a_parameter_is_that_of_the_sensor(
    both: tuple[SensorConfig, Calibration], name: str, within: float
) -> None:
    sensor, calibration = both
    if name == "refractory_us" and 0.0 < sensor.follower_hz < SLOW_FOLLOWER_HZ:
        within = 0.16
    found = next(p for p in calibration.parameters if p.name == name)
    assert getattr(calibration.sensor, name) == found.value
    assert found.value == pytest.approx(getattr(sensor, name), rel=within), found.evidence


def test_what_only_the_first_round_tells_stays_at_the_start(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rounds: list[float] = []

    def told_once(fit: object) -> Fit:
        """Stand for the page of the noise, of which only the first round tells the leak."""
        started = fit.start.leak_hz  # type: ignore[attr-defined]
        rounds.append(started)
        leak = Parameter("leak_hz", "Hz", 0.5, None, "") if len(rounds) == 1 else None
        return Fit("noise", (leak or unknown("leak_hz", "Hz", "a reason"),), Section("", "", ()))

    monkeypatch.setattr(calibration_module, "noise_page", told_once)
    sensor = SENSORS["the default"]
    events, frames = recorded(sensor)
    recording = from_aps(events, frames, sensor.aps, name="made")
    found = calibrate(recording, start_for(sensor))
    assert rounds == [sensor.leak_hz] * 2
    assert found.sensor.leak_hz == sensor.leak_hz
