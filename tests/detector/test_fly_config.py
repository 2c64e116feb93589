import pytest

from detector.errors import DetectorConfigError, DetectorError
from detector.fly_config import FlyConfig


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
        ("floor", 0.0),
        ("roi_share", 0.0),
    ],
)
def test_a_value_outside_its_range_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(DetectorConfigError, match=f"{name} is .*allowed is .*value is"):
        FlyConfig(**{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["window_us", "delay_us"])
def test_a_window_that_is_no_multiple_of_the_hop_is_refused(name: str) -> None:
    with pytest.raises(DetectorError, match=f"{name} is 45000 µs, no multiple of hop_us"):
        FlyConfig(**{name: 45_000})  # type: ignore[arg-type]


def test_a_quiet_limit_shorter_than_memory_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match="quiet_limit_us is 99999 µs"):
        FlyConfig(quiet_limit_us=99_999)
