"""The figure of a sweep."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenarios.errors import ScenarioError
from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep import plot
from scenarios.sweep.plan import Point
from scenarios.sweep.plot import VALUE, write_plot

SPEED, LUX = "crossing.omega_rad_s", "crossing.illuminance_lux"


def points_of(*varied: dict[str, Any], labels: dict[str, str] | None = None) -> list[Point]:
    return [Point(RunConfig(), labels or {}, values) for values in varied]


def test_two_parameters_give_a_map_of_means_for_each_method(tmp_path: Path) -> None:
    varied: list[dict[str, Any]] = [
        {SPEED: speed, LUX: lux, "method": method, "seed": seed}
        for speed in (2.0, 1.0)
        for lux in (10, 1)
        for method in ("fly", "wide")
        for seed in (0, 1)
    ]
    table: list[dict[str, Any]] = [
        {VALUE: row["seed"] if row["method"] == "fly" else None} for row in varied
    ]
    table[0][VALUE] = 0.5
    write_plot(tmp_path / "a.png", points_of(*varied), table, VALUE)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    rows = [dict(row) | found for row, found in zip(varied, table, strict=True)]
    assert plot._axes(rows, VALUE) == [SPEED, LUX]
    fly = plot._panels(rows, ["method"])["fly"]
    cells = plot._map(fly, (SPEED, LUX), ([1.0, 2.0], [1, 10]), VALUE)
    assert cells.tolist() == [[0.5, 0.5], [0.5, 0.75]]
    wide = plot._panels(rows, ["method"])["wide"]
    assert np.isnan(plot._map(wide, (SPEED, LUX), ([1.0, 2.0], [1, 10]), VALUE)).all()


def test_one_parameter_gives_curves(tmp_path: Path) -> None:
    varied = [{SPEED: speed, "method": m} for speed in (1.0, 30.0) for m in ("fly", "a:$B$")]
    table = [{VALUE: 0.5, "events.count": 3} for _ in varied]
    write_plot(tmp_path / "a.png", points_of(*varied), table, "events.count")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_names_of_levels_are_an_axis() -> None:
    rows = [{"clutter": name, SPEED: s, VALUE: 1} for name in ("calm", "busy") for s in (1, 2)]
    assert plot._axes(rows, VALUE) == [SPEED, "clutter"]
    assert plot._levels(rows, "clutter") == ["calm", "busy"]


@pytest.mark.parametrize(
    ("varied", "value", "message"),
    [
        ([{"method": "fly"}, {"method": "wide"}], VALUE, "nothing to plot against"),
        ([{SPEED: 1.0}, {SPEED: 2.0}], "detector.x", r"--plot-value is detector\.x.*accuracy"),
        (
            [{SPEED: s, LUX: s, "sensor.theta_on": s / 100} for s in range(1, 20)],
            VALUE,
            "19 maps, one for each combination of sensor.theta_on",
        ),
    ],
)
def test_what_cannot_be_plotted_is_refused(
    tmp_path: Path, varied: list[dict[str, Any]], value: str, message: str
) -> None:
    table = [{VALUE: 0.5} for _ in varied]
    with pytest.raises(ScenarioError, match=message):
        write_plot(tmp_path / "a.png", points_of(*varied), table, value)
    assert list(tmp_path.iterdir()) == []
