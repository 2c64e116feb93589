"""`flybench validate`: what it prints and writes, on made recordings and on real ones."""

import csv
import json
import os
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from scenarios.commands.validate import Validate
from scenarios.output.terminal import execute
from scenarios.validate.manifest import PACKAGED, read_manifest
from scenarios.validate.turns import TURNS
from tests.scenarios.validate.made_recordings import (
    entry,
    rightward,
    still,
    write_manifest,
    write_recording,
)

REAL = os.environ.get("FLYBENCH_RECORDINGS")
"""Folder with the files of the packaged manifest; the tests of real recordings need it."""


@pytest.fixture(scope="module")
def manifest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    moving = write_recording(folder / "box.npz", rightward())
    calm = write_recording(folder / "calm.npz", still())
    return write_manifest(
        folder / "made.toml",
        (
            entry("box", "box.npz", moving, conditions="a <b>box</b>"),
            [{"direction": "right", "from_s": 0.0, "to_s": 0.3}],
        ),
        (entry("calm", "calm.npz", calm), [{"direction": "none", "crop": [0, 0, 200, 160]}]),
    )


def rows_of(out: Path) -> list[dict[str, str]]:
    with (out / "results.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_it_prints_and_writes_every_method_in_every_variant(
    manifest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert execute(Validate(manifest, method=("fly", "frame-fly"), out=out)) == 0
    printed = capsys.readouterr().out
    for words in ("box, 0.00 to 0.30 s: → right", "calm, 0.00 to 0.30 s: nothing moves"):
        assert words in printed
    assert "frame-based fly: The method needs APS frames" in printed
    rows = rows_of(out)
    assert len(rows) == 2 * len(TURNS) * 2
    truths = [row["truth"] for row in rows if row["method"] == "fly"]
    assert truths == ["right", "left", "down", "left", "up", *["none"] * 5]
    for row in rows:
        if row["method"] == "frame-fly":
            assert (row["steps"], row["note"][:27]) == ("0", "The method needs APS frames")
        elif row["truth"] == "none":
            assert (row["right"], row["wrong"], row["false_alarms"]) == (row["steps"], "", "0")
            assert int(row["steps"]) == 29  # the last event is just before 0.3 s
        else:
            assert int(row["right"]) > 15
            assert (row["wrong"], row["false_alarms"], row["verdict"]) == ("0", "", row["truth"])
    assert {path.name for path in out.iterdir()} == {"results.csv", "report.html", "summary.json"}


class Failing:
    """Detector that raises an error."""

    def __init__(self, *, width: int, height: int) -> None: ...

    def push(self, _events: Any) -> list[Any]:
        """Fail."""
        raise ZeroDivisionError("no wind")

    def advance(self, _t_us: int) -> list[Any]:
        """Return nothing."""
        return []


def test_a_detector_that_fails_is_named_once_and_the_others_are_scored(
    manifest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, bad = tmp_path / "out", f"{__name__}:Failing"
    chosen: Any = {"recording": ("box",), "out": out}
    assert execute(Validate(manifest, method=("fly", bad), **chosen)) == 1
    captured = capsys.readouterr()
    line = f"flybench: box, window 1, 5 of 5 variants: {bad}: push raised an error after"
    assert captured.err.count(line) == 1
    assert f"{bad}: push raised an" in captured.out
    assert f"{bad}: {bad}" not in captured.out + captured.err
    for row in rows_of(out):
        assert (row["method"] == bad) == row["failed"].startswith("push raised an error after")
    (failed,) = json.loads((out / "summary.json").read_text())["failed"]
    assert f"flybench: {failed}" in captured.err
    assert "failed after 0 steps" in (out / "report.html").read_text(encoding="utf-8")


def test_nothing_is_written_if_every_detector_fails(
    manifest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chosen: Any = {"method": (f"{__name__}:Failing",), "recording": ("box",)}
    assert execute(Validate(manifest, out=tmp_path / "out", **chosen)) == 2
    assert "No method ran to the end of a window. box, window 1" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_page_shows_images_and_scores_and_is_well_formed(
    manifest: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert execute(Validate(manifest, method=("fly",), recording=("box",), out=out)) == 0
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == 4
    assert "a &lt;b&gt;box&lt;/b&gt;" in page
    assert "5 of 5" in page
    assert "calm" not in page
    assert "<script" not in page
    assert re.findall(r'(?:src|href)="(?!data:|#)', page) == []  # nothing to load
    body = page[page.index("<body>") : page.index("</body>") + len("</body>")]
    ElementTree.fromstring(re.sub(r"(<img[^>]*|<br)>", r"\1/>", body))


def test_an_error_leaves_the_earlier_result(
    manifest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert execute(Validate(manifest, method=("fly",), recording=("box",), out=out)) == 0
    before = (out / "report.html").read_bytes()
    broken = tmp_path / "broken.toml"
    broken.write_text(manifest.read_text().replace("direction = 'none'", "direction = 'odd'"))
    assert execute(Validate(broken, out=out)) == 2
    captured = capsys.readouterr()
    assert f"flybench: {broken}: recording 2 (calm), window 1: direction is 'odd'" in captured.err
    assert (out / "report.html").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def test_a_window_that_does_not_fit_names_the_manifest(
    manifest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    late = manifest.with_name("late.toml")
    late.write_text(manifest.read_text().replace("to_s = 0.3", "to_s = 3.0"))
    assert execute(Validate(late, method=("fly",), out=tmp_path / "out")) == 2
    assert f"flybench: {late}: box: to_s is 3 and the last event is at" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"method": ("bee",)}, "The method is 'bee'. Allowed is fly"),
        ({"manifest": Path("none.toml")}, "none.toml cannot be read"),
        ({"recording": ("tank",)}, "--recording is 'tank'. Allowed with"),
        ({"folder": Path("nowhere")}, "does not exist. Get it from"),
    ],
)
def test_invalid_arguments_give_a_one_line_error(
    changes: Any, words: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert execute(Validate(**({"out": tmp_path / "out"} | changes))) == 2
    err = capsys.readouterr().err
    assert words in err
    assert len([line for line in err.splitlines() if line.startswith("flybench: ")]) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(REAL is None, reason="FLYBENCH_RECORDINGS names no folder")
@pytest.mark.parametrize("name", [r.name for r in read_manifest(PACKAGED).recordings])
def test_real_recordings_can_be_read_and_scored(name: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    chosen: Any = {"method": ("fly", "contrast-maximisation"), "recording": (name,)}
    assert execute(Validate(folder=Path(str(REAL)), out=out, **chosen)) == 0
    (recording,) = read_manifest(PACKAGED).select([name]).recordings
    rows = rows_of(out)
    assert len(rows) == len(recording.windows) * len(TURNS) * 2
    for row in rows:
        window = recording.windows[int(row["window"]) - 1]
        if window.to_us is not None:  # a step every 10 ms, to the end of the window
            assert int(row["steps"]) == (window.to_us - window.from_us) // 10_000


@pytest.mark.skipif(REAL is None, reason="FLYBENCH_RECORDINGS names no folder")
def test_robust_holds_on_real_recordings_however_they_are_turned(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert execute(Validate(folder=Path(str(REAL)), out=out, method=("robust",))) == 0
    shares: dict[str, list[float]] = {}
    variants: dict[tuple[str, str], set[tuple[str, str]]] = {}
    for row in rows_of(out):
        shares.setdefault(row["recording"], []).append(int(row["right"]) / int(row["steps"]))
        window = row["recording"], row["window"]
        variants.setdefault(window, set()).add((row["right"], row["wrong"]))
        assert row["verdict"] == (row["truth"] if row["truth"] != "none" else "nothing moves")
    assert {window: len(found) for window, found in variants.items()} == dict.fromkeys(variants, 1)
    assert min(shares["cradle"]) >= 0.95
    assert min(shares["pipe"]) >= 0.9
    assert shares["lab"] == [1.0] * len(TURNS)
