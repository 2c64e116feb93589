"""The command `flybench dataset`."""

from pathlib import Path

import pytest

from scenarios.commands.data.dataset import Dataset
from scenarios.dataset.plan import read_plan
from scenarios.dataset.size import duration_s, estimated_bytes
from scenarios.errors import ScenarioError
from scenarios.output.terminal import execute
from sim import Crossing
from tests.scenarios.dataset.tiny import write_spec


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    return write_spec(tmp_path / "tiny.toml")


def test_a_dry_run_lists_the_sequences_and_writes_nothing(
    spec: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert Dataset(spec, out=tmp_path / "out", dry_run=True).execute() == 0
    printed = capsys.readouterr().out
    assert "3 sequences, together about " in printed
    assert "0 finished" in printed
    assert all(name in printed for name in ("train/0001", "test/0000", "crossing.omega_rad_s"))
    assert [path.name for path in tmp_path.iterdir()] == ["tiny.toml"]


def test_a_dataset_is_written_and_resumed(
    spec: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = spec.read_text().replace("train = 2", "train = 1")
    write_spec(
        spec,
        text[: text.index("wanted")]
        + 'wanted = ["motion", "boxes"]\n'
        + text[text.index("[sensor]") :],
    )
    out = tmp_path / "out"
    assert Dataset(spec, out=out, jobs=1).execute() == 0
    printed = capsys.readouterr().out
    assert "checksums.sha256 in it: 2 sequences, " in printed
    assert "0 finished before" in printed
    assert "CPU time of a sequence: " in printed
    assert {path.name for path in (out / "train/0000").iterdir()} == {
        "events",
        "images",
        "motion.csv",
        "object_detections",
        "summary.json",
    }
    assert Dataset(spec, out=out).execute() == 0
    printed = capsys.readouterr().out
    assert "2 finished before" in printed
    assert "CPU time" not in printed


def test_bad_input_is_one_sentence_and_nothing_is_written(
    spec: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_spec(spec, spec.read_text().replace("omega_rad_s", "omega"))
    assert execute(Dataset(spec, out=tmp_path / "out")) == 2
    assert capsys.readouterr().err.startswith(f"flybench: {spec}: There is no parameter crossing.o")
    with pytest.raises(ScenarioError, match=r"--jobs is 2 and --dask is tcp://x\. Allowed is only"):
        Dataset(spec, jobs=2, dask="tcp://x").execute()
    with pytest.raises(ScenarioError, match=r"jobs is 0\. Allowed is 1 or more"):
        Dataset(spec, jobs=0).execute()
    assert [path.name for path in tmp_path.iterdir()] == ["tiny.toml"]


def test_the_estimated_duration_is_close(spec: Path) -> None:
    for plan in read_plan(spec).sequences:
        exact_s = Crossing(plan.crossing, plan.lens).duration_us / 1e6
        assert duration_s(plan) == pytest.approx(exact_s, rel=0.15)
        assert estimated_bytes(plan) > 100_000
