import json
from dataclasses import asdict

import numpy as np
import pytest

from detector.errors import DetectorConfigError, DetectorError
from detector.fly.config import FlyConfig
from detector.fly.model_variants import Averaging, Offsets


def test_defaults_are_table_one() -> None:
    c = FlyConfig()
    assert (c.tau_us, c.window_us) == (30_000, 50_000)
    assert (c.spacing_cells, c.spacings) == (4, 4)
    assert (c.g_m, c.g_p, c.roi_radius_px, c.cell_px) == (5.0, 30.0, 50, 3)
    assert (c.delay_us, c.hop_us) == (c.window_us, 10_000)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("tau_us", 0),
        ("cell_px", -3),
        ("alpha", 1.0),
        ("alpha", float("nan")),
        ("snr_floor", -1.0),
        ("share_floor", 1.5),
        ("further_delays_us", 100_000),
        ("further_delays_us", (0,)),
        ("further_delays_us", (100_000.5,)),
        ("further_delays_us", (50_000,) * 17),
        ("offsets", "odd"),
        ("roi_share", 0.0),
        ("g_m", float("inf")),
        ("tau_us", "x"),
        ("tau_us", None),
        ("cell_px", 2.5),
        ("cell_px", 3.0),
        ("spacings", 2.5),
        ("spacings", True),
        ("alpha", True),
        ("alpha", "0.5"),
        ("averaging", "mean"),
        ("averaging", True),
        ("averaging", ["events"]),
    ],
)
def test_the_refusal_of_a_value_names_its_parameter(name: str, value: object) -> None:
    with pytest.raises(DetectorConfigError, match=f"{name} is .*Allowed is "):
        FlyConfig(**{name: value})  # type: ignore[arg-type]


def test_the_refusal_of_a_choice_lists_the_choices() -> None:
    sentence = r"averaging is 'mean'\. Allowed is one of events, both, area, none\."
    with pytest.raises(DetectorConfigError, match=sentence):
        FlyConfig(averaging="mean")  # type: ignore[arg-type]


def test_a_configuration_survives_json() -> None:
    for averaging in Averaging:
        config = FlyConfig(averaging=averaging)
        again = FlyConfig(**json.loads(json.dumps(asdict(config))))
        assert again == config
        assert again.averaging is averaging


def test_numbers_of_numpy_become_python_numbers() -> None:
    config = FlyConfig(cell_px=np.int64(2), g_m=4, alpha=np.float32(0.5))  # type: ignore[arg-type]
    assert [type(v) for v in (config.cell_px, config.g_m, config.alpha)] == [int, float, float]


def test_a_hop_that_needs_too_much_memory_is_refused() -> None:
    assert FlyConfig(hop_us=100).window_hops == 500
    sentence = r"hop_us is 1 µs.* into 100000 hops. Allowed is 1000,.*longer hop"
    with pytest.raises(DetectorConfigError, match=sentence):
        FlyConfig(hop_us=1)


@pytest.mark.parametrize("name", ["window_us", "delay_us"])
def test_a_time_that_is_not_a_multiple_of_the_hop_is_refused(name: str) -> None:
    with pytest.raises(
        DetectorError, match=rf"{name} is 45000 µs\. Allowed is a multiple of hop_us"
    ):
        FlyConfig(**{name: 45_000})  # type: ignore[arg-type]


def test_a_quiet_limit_shorter_than_the_memory_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match="quiet_limit_us is 99999 µs"):
        FlyConfig(quiet_limit_us=99_999)


def test_distances_are_even_or_doubling() -> None:
    assert FlyConfig().offsets_cells == (4, 8, 12, 16)
    doubling = FlyConfig(spacing_cells=1, spacings=5, offsets=Offsets.DOUBLING)
    assert doubling.offsets_cells == (1, 2, 4, 8, 16)


def test_distances_beyond_any_sensor_are_refused() -> None:
    with pytest.raises(
        DetectorConfigError, match=r"spacings is 70: .*Allowed is 100000 cells or less"
    ):
        FlyConfig(offsets=Offsets.DOUBLING, spacings=70)
    assert FlyConfig(spacing_cells=1000, spacings=100).offsets_cells[-1] == 100_000


def test_a_preset_is_found_by_name() -> None:
    assert FlyConfig.preset("paper") == FlyConfig()
    wide = FlyConfig.preset("wide")
    assert wide.delays_hops == (3, 10, 20)
    assert FlyConfig(**json.loads(json.dumps(asdict(wide)))) == wide
    with pytest.raises(
        DetectorConfigError, match=r"preset is 'fast'\. Allowed is one of 'paper', "
    ):
        FlyConfig.preset("fast")
    with pytest.raises(DetectorConfigError, match=r"preset is \[\]\. Allowed is one of"):
        FlyConfig.preset([])  # type: ignore[arg-type]


def test_a_further_delay_must_fit_the_hop_and_the_quiet_limit() -> None:
    with pytest.raises(
        DetectorConfigError, match=r"further_delays_us is 45000 µs\. Allowed is a multiple"
    ):
        FlyConfig(further_delays_us=(100_000, 45_000))
    with pytest.raises(DetectorConfigError, match="longest delay = 250000 µs or more"):
        FlyConfig(further_delays_us=(200_000,), quiet_limit_us=249_999)


def test_a_window_far_longer_than_its_decay_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match=r"window_us is 50000 µs\. Allowed is 100 tau_us"):
        FlyConfig(tau_us=499)
