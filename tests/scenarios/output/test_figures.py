"""Figures as files."""

from pathlib import Path
from typing import Any

from scenarios.output.figures import figure_file, literal


def draw(path: Path) -> None:
    with figure_file(path, (3, 2)) as figure:
        figure.add_subplot().plot([1, 2], [3, 4])


def test_a_file_name_is_no_formula_and_is_always_drawn(tmp_path: Path) -> None:
    for name in ("a$b_{$.npz", "$", "a\\$b$", "a\udcff.npz"):
        with figure_file(tmp_path / "a", (3, 2)) as figure:
            title: Any = figure.suptitle(literal(name))
            text, is_formula = title._preprocess_math(title.get_text())
            assert not is_formula
            assert text == name.replace("\udcff", "\\udcff")


def test_equal_figures_give_equal_png_and_svg_files(tmp_path: Path) -> None:
    draw(tmp_path / "a.b")
    draw(tmp_path / "c")
    assert {path.name for path in tmp_path.iterdir()} == {"a.b.png", "a.b.svg", "c.png", "c.svg"}
    for ending in (".png", ".svg"):
        assert (tmp_path / f"a.b{ending}").read_bytes() == (tmp_path / f"c{ending}").read_bytes()
