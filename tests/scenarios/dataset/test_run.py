"""Datasets that are interrupted, resumed, changed or refused."""

import json
from functools import partial
from pathlib import Path

import pytest

from flybench import disk_space
from scenarios.dataset.folder import CARD, CHECKSUMS, LOCK, TABLE, dataset_folder
from scenarios.dataset.plan import read_plan
from scenarios.dataset.run import Task, run_dataset, run_task
from scenarios.dataset.sequence import file_digest
from scenarios.dataset.sequence_plan import code_digest
from scenarios.errors import OutputError, ScenarioError
from scenarios.output.atomic_folder import SUMMARY
from scenarios.pipeline.parallel import run_locally
from tests.scenarios.dataset.tiny import (
    QUICK,
    finished,
    make_quickly,
    must_not_run,
    quick_make,
    write_spec,
)
from tests.scenarios.sweep.quick_sweep import kill_and_resume, start

HERE = partial(run_locally, jobs=1)


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The file of a dataset, and the folder of an uninterrupted run."""
    path = tmp_path_factory.mktemp("made")
    file = write_spec(path / "quick.toml", QUICK)
    result = make_quickly(file, path / "out")
    assert len(result.costs) == len(result.summaries) == 12
    return file, path / "out"


def test_a_dataset_that_is_killed_and_resumed_has_the_same_files(
    made: tuple[Path, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    reached = kill_and_resume(
        lambda: start(make_quickly, made[0], folder), lambda: finished(folder), seed=5, most=5
    )
    assert any(0 < n < 12 for n in reached)
    assert reached == sorted(reached)
    assert contents(folder) == contents(made[1])


def test_the_checksums_are_those_of_all_files(made: tuple[Path, Path]) -> None:
    lines = (made[1] / CHECKSUMS).read_text().splitlines()
    listed = {line.split("  ")[1]: line.split("  ")[0] for line in lines}
    assert set(listed) == set(contents(made[1])) - {CHECKSUMS, LOCK}
    assert all(file_digest(made[1] / name) == digest for name, digest in listed.items())


def test_a_finished_sequence_is_not_made_again(made: tuple[Path, Path], tmp_path: Path) -> None:
    reported: list[tuple[int, int]] = []
    make_quickly(made[0], tmp_path / "out")
    done = run_dataset(
        read_plan(made[0]),
        tmp_path / "out",
        HERE,
        make=must_not_run,
        progress=lambda done, total, _: reported.append((done, total)),
    )
    assert done.costs == []
    assert reported == [(12, 12)]
    assert contents(tmp_path / "out") == contents(made[1])


def test_a_sequence_that_lacks_a_file_is_made_again(
    made: tuple[Path, Path], tmp_path: Path
) -> None:
    make_quickly(made[0], tmp_path / "out")
    (tmp_path / "out/train/0004/events/left/events.h5").unlink()
    assert len(make_quickly(made[0], tmp_path / "out").costs) == 1
    assert contents(tmp_path / "out") == contents(made[1])


def test_a_changed_file_replaces_only_what_it_changes(
    made: tuple[Path, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    make_quickly(made[0], folder)
    more = write_spec(tmp_path / "more.toml", QUICK.replace("train = 9", "train = 11"))
    assert len(make_quickly(more, folder).costs) == 2
    with pytest.raises(OutputError, match=r"holds 2 sequences of another dataset, such as"):
        make_quickly(made[0], folder)
    other = write_spec(
        tmp_path / "other.toml", QUICK.replace("train = 9", "train = 11").replace("8", "9")
    )
    assert len(make_quickly(other, folder).costs) == 14


def test_the_order_in_which_sequences_finish_changes_nothing(
    made: tuple[Path, Path], tmp_path: Path
) -> None:
    run = partial(run_locally, jobs=2)
    run_dataset(read_plan(made[0]), tmp_path / "out", run, make=quick_make)
    assert contents(tmp_path / "out") == contents(made[1])


def test_the_card_states_contents_licence_and_ranges(made: tuple[Path, Path]) -> None:
    card = (made[1] / CARD).read_text()
    assert card.startswith('---\nlicense: "cc0-1.0"\npretty_name: "Quick"\n')
    for words in ("| train | 9 |", "| test | 3 |", "`motion`", "## Licence", "numpy"):
        assert words in card
    assert "| `crossing.street_seed` | all | 0 to 4294967295 |" in card
    summary = json.loads((made[1] / SUMMARY).read_text())
    assert (summary["splits"], summary["events"]) == ({"train": 9, "test": 3}, 12 * 32)
    assert len((made[1] / TABLE).read_text().splitlines()) == 13


def test_a_second_process_in_one_folder_is_refused(made: tuple[Path, Path], tmp_path: Path) -> None:
    plan = read_plan(made[0])
    with (
        dataset_folder(tmp_path / "out", plan, 0),
        pytest.raises(OutputError, match=r"Another process is making the dataset in .*\. Allowed"),
    ):
        make_quickly(made[0], tmp_path / "out")


@pytest.mark.parametrize("name", ["thesis.txt", CARD, "train"])
def test_a_folder_of_something_else_is_refused_and_left_unchanged(
    name: str, made: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(OutputError, match="were not written by flybench"):
        make_quickly(made[0], tmp_path)
    assert contents(tmp_path) == {name: b"mine"}


def test_a_file_in_a_sequence_that_flybench_did_not_write_is_kept(
    made: tuple[Path, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    make_quickly(made[0], folder)
    (folder / "train/0003/notes.txt").write_text("mine")
    (folder / "train/0003" / SUMMARY).write_text("{}")  # so that it is made again
    with pytest.raises(OutputError, match=r"notes\.txt"):
        make_quickly(made[0], folder)
    assert (folder / "train/0003/notes.txt").read_text() == "mine"


def test_a_dataset_that_does_not_fit_on_the_disk_is_refused_before_work(
    made: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = disk_space.shutil._ntuple_diskusage(10**9, 10**9 - 1000, 1000)  # type: ignore[attr-defined]
    monkeypatch.setattr("flybench.disk_space.shutil.disk_usage", lambda _: usage)
    with pytest.raises(OutputError, match=r"has 0\.0 MB free\. The output needs about .* MB\. "):
        run_dataset(read_plan(made[0]), tmp_path / "out", HERE, make=must_not_run)
    assert list(tmp_path.iterdir()) == []


def test_a_worker_with_other_code_or_another_folder_is_named(
    made: tuple[Path, Path], tmp_path: Path
) -> None:
    plan = read_plan(made[0])
    sequence = plan.sequences[0]
    with pytest.raises(ScenarioError, match=r"A worker on .* runs another version of flybench"):
        run_task(Task(sequence, tmp_path, "", code="old"))
    with pytest.raises(ScenarioError, match=r"does not see the folder .* of a shared file system"):
        run_task(Task(sequence, tmp_path, "", code_digest()))
