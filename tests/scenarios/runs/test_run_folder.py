"""A finished run in Python and in a notebook."""

import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from detector.estimate import MotionEstimate
from emulator import SensorOutput
from flybench import open_run
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE
from scenarios.errors import ScenarioError
from scenarios.output.tables import ESTIMATE_COLUMNS, estimate_row, write_table
from scenarios.runs import run_folder
from scenarios.styles.method_style import method_style
from tests.scenarios.study.synthetic_results import make_estimate

SCORES = {
    "method": "fly",
    "direction": "right",
    "accuracy": 0.9,
    "accuracy_after_100ms": 1.0,
    "steps_in_view": 40,
    "latency_ms": 50.0,
    "roi_iou": 0.7,
    "centroid_error_px": 3.0,
    "grms": 80_500.0,
}
RUN = {
    "generator": "flybench",
    "truth": {
        "direction": "right",
        "omega_rad_s": 1.61,
        "speed_km_h": 40.0,
        "image_speed_px_s": 520.0,
        "duration_us": 900_000,
        "enters_view_us": 200_000,
        "leaves_view_us": 700_000,
    },
    "events": {
        "count": 1200,
        "on": 700,
        "off": 500,
        "by_cause": {"signal": 1000, "leak": 100, "shot": 90, "hot": 10},
    },
    "detector": SCORES,
    "wall_s": {"total": 2.0},
}


def make_folder(folder: Path, summary: dict[str, Any] = RUN) -> Path:
    folder.mkdir()
    (folder / "summary.json").write_text(json.dumps(summary))
    estimates = [make_estimate("fly", 10_000 * k, 0.01 * k, 400.0) for k in range(1, 80)]
    write_table(folder / "estimates.csv", ESTIMATE_COLUMNS, map(estimate_row, estimates))
    return folder


def test_a_run_displays_its_results_and_its_response(tmp_path: Path) -> None:
    page = open_run(make_folder(tmp_path / "a & b"))._repr_html_()
    root = ElementTree.fromstring(page)
    assert "flybench run a & b" in " ".join(root.itertext())
    assert re.search("<th[^>]*>verdict</th><td[^>]*>right</td>", page)
    assert method_style("fly").colour.lower() in page
    assert "target in view" in page


def test_the_tables_of_a_run_are_arrays(tmp_path: Path) -> None:
    run = open_run(make_folder(tmp_path / "run"))
    assert run.method == "fly"
    assert run.estimates["t_us"].tolist() == list(range(10_000, 800_000, 10_000))
    assert run.estimates["direction"][0] == "right"
    with pytest.raises(ScenarioError, match=r"truth.csv cannot be read"):
        _ = run.truth


def test_a_run_whose_detector_failed_has_no_picture(tmp_path: Path) -> None:
    failed = RUN | {"detector": {"method": "fly", "failed": "no <idea>", "estimates": 0}}
    folder = make_folder(tmp_path / "run", failed)
    (folder / "estimates.csv").unlink()
    page = open_run(folder)._repr_html_()
    assert "<svg" not in page
    assert "failed" in page


@pytest.mark.parametrize("text", [None, "{", "[]", '{"generator": "another"}'])
def test_another_folder_is_refused(tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / "summary.json").write_text(text)
    with pytest.raises(ScenarioError, match=r"is not the folder of a run. Allowed is"):
        open_run(tmp_path)


def test_the_viewer_needs_a_recording_and_its_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = open_run(make_folder(tmp_path / "run"))
    with pytest.raises(ScenarioError, match=r"has no recording.rrd"):
        run.show()
    (run.folder / "recording.rrd").write_bytes(b"RRF2")
    monkeypatch.setattr(run_folder, "has_notebook_viewer", lambda: False)
    with pytest.raises(ScenarioError, match="pip install rerun-notebook"):
        run.show()


def test_an_estimate_and_a_sensor_step_display_themselves() -> None:
    estimate = MotionEstimate(
        12_000, 0.5, -0.1, Direction.RIGHT, 0.5, (1.0, 0.0), (3.0, 4.0), (1, 2, 3, 4)
    )
    for text in ("0.012 s", "right", "+0.500", "(3.0, 4.0) px", "(1, 2, 3, 4) px"):
        assert text in estimate._repr_html_()
    events = np.zeros(3, EVENT_DTYPE)
    events["p"] = True, False, True
    page = SensorOutput(events, np.array([0, 0, 1], np.uint8), ())._repr_html_()
    assert re.search("<th[^>]*>ON, OFF</th><td[^>]*>2, 1</td>", page)
    assert re.search("<th[^>]*>signal</th><td[^>]*>2</td>", page)
