"""Maps of an envelope."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from scenarios.envelope.maps import draw_comparison, draw_levels, draw_map, draw_method
from scenarios.envelope.table import CORRECT, OPPOSITE
from tests.scenarios.envelope.made_up_rows import made_up_row

SPEEDS = (30.0, 350.0, 2000.0)
ROWS = [
    made_up_row(method, correct=min(1.0, v / 360), speed_px_s=v, noise_hz=n, direction=d)
    for method in ("fly", "wide")
    for v in SPEEDS
    for n in (0.0, 1.0)
    for d in ("right", "up")
]
FLY = [r for r in ROWS if r["method"] == "fly"]


def svg_text(path: Path) -> str:
    return path.with_suffix(".svg").read_text()


def test_the_figure_of_a_method_has_a_map_for_every_factor_that_varies(tmp_path: Path) -> None:
    draw_method(tmp_path / "fly", FLY, CORRECT, crossed=("direction",))
    svg = svg_text(tmp_path / "fly")
    for words in ("by noise (mean of directions)", "by direction", "image speed [px/s]"):
        assert words in svg
    assert "by contrast" not in svg
    assert (tmp_path / "fly.png").stat().st_size > 10_000


def test_the_comparison_shows_all_methods(tmp_path: Path) -> None:
    draw_comparison(tmp_path / "both", ROWS, crossed=("direction",))
    svg = svg_text(tmp_path / "both")
    for words in ("event-driven fly", "event-driven fly, wide", "correct, %", "worst direction"):
        assert words in svg


def test_a_crossed_factor_has_one_map_per_level(tmp_path: Path) -> None:
    draw_levels(tmp_path / "by_direction", ROWS, "direction")
    svg = svg_text(tmp_path / "by_direction")
    assert "event-driven fly, wide" in svg
    assert "correct, direction up" in svg


def test_every_cell_shows_its_share() -> None:
    axes = Figure().add_subplot()
    draw_map(axes, FLY, "noise_hz", CORRECT, title="correct")
    labels = {(*text.get_position(), text.get_text()) for text in axes.texts}
    assert labels == {(x, y, t) for y in (0, 1) for x, t in enumerate(("8", "97", "100"))}
    image = axes.images[0].get_array()
    assert image is not None
    np.testing.assert_allclose(image[0], [30 / 360, 350 / 360, 1.0])


def test_the_outline_encloses_the_cells_with_enough_correct_steps() -> None:
    axes = Figure().add_subplot()
    draw_map(axes, FLY, "noise_hz", CORRECT, title="correct")
    outline = [line for line in axes.lines if line.get_color() == "#e4572e"]
    corners = np.array([line.get_xydata() for line in outline]).reshape(-1, 2)
    assert corners.min(axis=0) == pytest.approx([0.5, -0.5])
    assert corners.max(axis=0) == pytest.approx([2.5, 1.5])
    plain = Figure().add_subplot()
    draw_map(plain, FLY, "noise_hz", OPPOSITE, title="opposite")
    assert not [line for line in plain.lines if line.get_color() == "#e4572e"]


def test_tilt_has_a_map_for_every_surface_that_was_tilted(tmp_path: Path) -> None:
    rows = [
        made_up_row("fly", speed_px_s=v, tilt_deg=tilt, surface=surface)
        for v in SPEEDS
        for tilt in (0.0, 15.0)
        for surface in ("panels", "bar")
    ]
    rows += [made_up_row("fly", speed_px_s=v, surface="saloon") for v in SPEEDS]
    draw_method(tmp_path / "fly", rows, CORRECT, crossed=())
    svg = svg_text(tmp_path / "fly")
    assert "by tilt<" in svg
    assert "by tilt of a bar<" in svg
    assert "by tilt of a saloon" not in svg
    assert "steps, %" in svg  # the colour bar
    assert "grey cell without a number has no step" in " ".join(svg.split())
