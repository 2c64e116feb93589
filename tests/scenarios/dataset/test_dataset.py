"""A rendered dataset: its files are those of DSEC, agree with each other and with the truth."""

import csv
import hashlib
import io
import json
import math
import sys
import tarfile
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import h5py
import numpy as np
import numpy.typing as npt
import pytest

from flybench.events import EVENT_DTYPE
from scenarios.dataset.labels.boxes import TRACK_DTYPE
from scenarios.dataset.plan import DatasetPlan, read_plan
from scenarios.dataset.run import run_dataset
from scenarios.pipeline.parallel import run_locally
from sim import Crossing
from sim.event_truth import event_truth
from sim.truth.dense_truth import DenseTruth
from tests.scenarios.dataset.tiny import write_spec

PERIOD_US = 50_000


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[DatasetPlan, Path]:
    """A dataset, and its folder."""
    path = tmp_path_factory.mktemp("dataset")
    plan = read_plan(write_spec(path / "tiny.toml"))
    run_dataset(plan, path / "out", partial(run_locally, jobs=1))
    return plan, path / "out"


@pytest.fixture(scope="module", params=[0, 1], ids=["day", "night"])
def sequence(made: tuple[DatasetPlan, Path], request: Any) -> tuple[Crossing, Path]:
    """The crossing of one sequence, and its folder."""
    plan = made[0].sequences[request.param]
    return Crossing(plan.crossing, plan.lens), made[1] / plan.name


def read_image(path: Path) -> npt.NDArray[Any]:
    """Read an image as users of DSEC do."""
    image = cv2.imread(str(path), cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR)
    assert image is not None
    return np.asarray(image)


def digests(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_the_same_file_gives_the_same_bytes_in_other_processes(
    made: tuple[DatasetPlan, Path], tmp_path: Path
) -> None:
    run_dataset(made[0], tmp_path / "again", partial(run_locally, jobs=2))
    assert digests(tmp_path / "again") == digests(made[1])
    assert len(digests(made[1])) > 150


def window(file: Any, start_us: int, end_us: int) -> dict[str, npt.NDArray[Any]]:
    """Look up the events of a window by the index of milliseconds, as DSEC's slicer does."""
    offset, index = int(file["t_offset"][()]), np.asarray(file["ms_to_idx"], np.int64)
    first, last = (start_us - offset) // 1000, -(-(end_us - offset) // 1000)
    part = slice(index[first], index[last])  # an IndexError if the index is too short
    t = file["events/t"][part] + offset
    inside = slice(*np.searchsorted(t, [start_us, end_us]))
    return {"t": t[inside]} | {name: file[f"events/{name}"][part][inside] for name in "xyp"}


def test_events_and_their_index_are_those_of_dsec(sequence: tuple[Crossing, Path]) -> None:
    with h5py.File(sequence[1] / "events/left/events.h5") as file:
        t, index = file["events/t"][:], file["ms_to_idx"][:].astype(int)
        for ms in range(len(index)):
            assert index[ms] == len(t) or t[index[ms]] >= ms * 1000
            assert index[ms] == 0 or t[index[ms] - 1] < ms * 1000
        times = np.loadtxt(sequence[1] / "images/timestamps.txt", np.int64)
        for start_us, end_us in pairwise(times):
            events = window(file, int(start_us), int(end_us))
            assert len(events["t"]) == np.count_nonzero((t >= start_us) & (t < end_us)) > 0
        assert [file[f"events/{name}"].dtype.kind for name in "txyp"] == ["i", "u", "u", "u"]
        y, x = file["events/y"][:], file["events/x"][:]
    with h5py.File(sequence[1] / "events/left/rectify_map.h5") as file:
        rectified = file["rectify_map"][:][y, x]
    assert (rectified == np.stack([x, y], axis=-1)).all()


def test_flow_has_the_values_of_the_truth_forward_and_backward(
    sequence: tuple[Crossing, Path],
) -> None:
    crossing, folder = sequence
    geometry = DenseTruth(crossing.scene, crossing.intrinsics)
    fastest = 0.0
    for name, step in (("forward", 1), ("backward", -1)):
        times = np.loadtxt(folder / f"flow/{name}_timestamps.txt", np.int64, delimiter=",")
        files = sorted((folder / "flow" / name).glob("*.png"))
        assert len(files) == len(times) >= 4
        for path, (from_us, to_us) in zip(files, times, strict=True):
            assert (from_us, to_us - from_us) == (int(path.stem) * PERIOD_US, step * PERIOD_US)
            coded = read_image(path)[..., ::-1]  # OpenCV returns blue, green, red
            flow = (coded[..., :2].astype(float) - 2**15) / 128
            expected = geometry.displacement_px(*map(crossing.seconds, (from_us, to_us)))
            inside = (np.abs(expected) < 255.9).all(axis=-1)
            assert (coded[inside, 2] == 1).all()
            assert np.abs(flow - expected)[inside].max() < 0.005
            fastest = max(fastest, float(np.abs(flow).max()))
    assert fastest > 5


def test_depth_masks_and_velocity_have_the_values_of_the_truth(
    sequence: tuple[Crossing, Path],
) -> None:
    crossing, folder = sequence
    geometry = DenseTruth(crossing.scene, crossing.intrinsics)
    with h5py.File(folder / "flow/velocity.h5") as file:
        velocity, times = file["velocity_px_s"][:], file["t_us"][:]
    assert (times == np.loadtxt(folder / "images/timestamps.txt")).all()
    for k, t_us in enumerate(times):
        t_s = crossing.seconds(int(t_us))
        depth, expected = read_image(folder / f"depth/{k:06d}.png") / 256, geometry.depth_m(t_s)
        near = expected < 255
        assert np.abs(depth - expected)[near].max() < 0.002
        assert (depth[np.isinf(expected)] == 0).all()
        assert (velocity[k] == geometry.flow_px_s(t_s)).all()
        mask = read_image(folder / f"masks/{k:06d}.png").astype(int) - 1
        body = geometry.visible(t_s).body
        owner = np.where(body > 0, geometry.object_of_body[np.maximum(body, 0)], -1)
        assert (mask == owner).all()


def test_boxes_enclose_the_masks_and_match_the_times_of_images(
    sequence: tuple[Crossing, Path],
) -> None:
    folder = sequence[1]
    tracks = np.load(folder / "object_detections/left/tracks.npy")
    times = np.loadtxt(folder / "images/timestamps.txt", np.int64)
    images = sorted((folder / "images/left/distorted").glob("*.png"))
    assert tracks.dtype == TRACK_DTYPE
    assert len(images) == len(times)
    assert set(tracks["t"]) <= set(times.astype(np.uint64))
    assert {int(c) for c in tracks["class_id"]} == {0, 2}  # a pedestrian and a car
    for box in tracks:
        mask = read_image(folder / f"masks/{int(box['t']) // PERIOD_US:06d}.png")
        rows, columns = np.nonzero(mask == box["track_id"] + 1)
        corner = columns.min(), rows.min(), columns.max() + 1, rows.max() + 1
        x, y, w, h = (box[name] for name in "xywh")
        assert (x, y, x + w, y + h) == corner
    assert read_image(images[3]).shape == (64, 96, 3)
    assert read_image(images[3]).std() > 5


def test_coco_files_of_a_split_join_its_sequences(made: tuple[DatasetPlan, Path]) -> None:
    document = json.loads((made[1] / "annotations_train.json").read_text())
    images = {image["id"]: image for image in document["images"]}
    assert len(images) == len(document["images"])
    assert {name["file_name"].split("/")[1] for name in images.values()} == {"0000", "0001"}
    numbers = [annotation["id"] for annotation in document["annotations"]]
    assert numbers == list(range(1, len(numbers) + 1))
    categories = {entry["id"]: entry["name"] for entry in document["categories"]}
    for annotation in document["annotations"]:
        image = images[annotation["image_id"]]
        assert (made[1] / image["file_name"]).exists()
        assert image["file_name"].startswith(annotation["sequence"])
        assert categories[annotation["category_id"]] in ("car", "person")
        coded = annotation["segmentation"]
        values = np.arange(len(coded["counts"])) % 2 == 1
        mask = np.repeat(values, coded["counts"]).reshape(coded["size"], order="F")
        assert mask.sum() == annotation["area"]
        x, y, w, h = annotation["bbox"]
        assert mask[y : y + h, x : x + w].sum() == annotation["area"]


def test_every_event_has_its_source_cause_and_flow(sequence: tuple[Crossing, Path]) -> None:
    crossing, folder = sequence
    with h5py.File(folder / "events/left/events.h5") as file:
        events = np.zeros(len(file["events/t"]), EVENT_DTYPE)
        for name in "txyp":
            events[name] = file[f"events/{name}"][:]
    with h5py.File(folder / "events/left/event_labels.h5") as file:
        source, cause, flow = (file[name][:] for name in ("source", "cause", "flow_px_s"))
    truth = event_truth(events, cause, crossing)
    assert (source == truth.source).all()
    assert np.array_equal(flow, truth.flow_px_s, equal_nan=True)
    assert ((source == -2) == (cause > 0)).all()
    assert np.count_nonzero(source == 0) > 1000
    counts = json.loads((folder / "summary.json").read_text())["events"]
    assert counts["count"] == len(events)
    assert list(counts["by_cause"].values()) == np.bincount(cause, minlength=4).tolist()


def test_a_shard_holds_the_same_events_and_images_sample_by_sample(
    sequence: tuple[Crossing, Path],
) -> None:
    folder = sequence[1]
    times = np.loadtxt(folder / "images/timestamps.txt", np.int64)
    samples: dict[str, dict[str, bytes]] = {}
    with tarfile.open(folder / "shard.tar") as tar:
        for member in tar:
            key, _, ending = member.name.partition(".")
            content = tar.extractfile(member)
            assert content is not None
            assert list(samples)[-1:] in ([key], []) or key not in samples  # one after another
            samples.setdefault(key, {})[ending] = content.read()
    assert len(samples) == len(times) - 1
    with h5py.File(folder / "events/left/events.h5") as file:
        t = file["events/t"][:]
    for k, (key, files) in enumerate(samples.items()):
        assert key == f"train_{folder.name}_{k:06d}"
        document = json.loads(files["json"])
        assert [document["t_us"], document["next_t_us"]] == times[k : k + 2].tolist()
        assert document["direction"] == sequence[0].config.direction.value
        events = np.load(io.BytesIO(files["events.npy"]))
        inside = t[(t >= times[k]) & (t < times[k + 1])]
        assert (events["t"] == inside).all()
        assert files["flow.png"] == (folder / f"flow/forward/{k:06d}.png").read_bytes()
        assert files["image.png"] == (folder / f"images/left/distorted/{k:06d}.png").read_bytes()
        assert ("flow_backward.png" in files) == (k > 0)
        tracks = np.load(folder / "object_detections/left/tracks.npy")
        expected = tracks[tracks["t"] == times[k]]
        boxes = json.loads(files["boxes.json"])
        read = np.array([tuple(box.values()) for box in boxes], TRACK_DTYPE)
        assert [list(box) for box in boxes] == [list(TRACK_DTYPE.names or ())] * len(boxes)
        assert (read == expected).all()


def test_direction_speed_and_camera_are_stated(sequence: tuple[Crossing, Path]) -> None:
    crossing, folder = sequence
    with (folder / "motion.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    target = [row for row in rows if row["track_id"] == "0"]
    assert {row["direction"] for row in target} == {crossing.config.direction.value}
    fastest = max(float(row["angular_velocity_rad_s"]) for row in target)
    assert fastest == pytest.approx(crossing.config.omega_rad_s, rel=0.1)
    assert {row["kind"] for row in rows} == {"sedan", "pedestrian"}
    with (folder / "poses.csv").open(newline="") as file:
        pose = next(csv.DictReader(file))
    quaternion = np.array([float(pose[name]) for name in ("qx", "qy", "qz", "qw")])
    assert np.linalg.norm(quaternion) == pytest.approx(1)
    x, y, z, w = quaternion
    forward = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    assert forward == pytest.approx(crossing.scene.pose.forward, abs=1e-9)
    text = (folder / "calibration/cam_to_cam.yaml").read_text()
    assert f"camera_matrix: [{crossing.intrinsics.focal_px}, " in text
    assert "resolution: [96, 64]" in text


def test_frames_have_their_exposures(sequence: tuple[Crossing, Path]) -> None:
    folder = sequence[1] / "aps"
    exposures = np.loadtxt(folder / "exposure_timestamps.txt", np.int64, delimiter=",", ndmin=2)
    frames = sorted(folder.glob("*.png"))
    assert len(frames) == len(exposures)
    assert (exposures[:, 1] > exposures[:, 0]).all()
    for path in frames:
        image = read_image(path)
        assert image.dtype == np.uint16
        assert image.shape == (64, 96)
        assert 0 < image.max() <= 1023


def test_the_card_and_the_table_describe_what_is_there(made: tuple[DatasetPlan, Path]) -> None:
    card = (made[1] / "README.md").read_text()
    assert "| `crossing.vehicle` | train | one of sedan |" in card
    assert "| `crossing.vehicle` | test | one of van |" in card
    assert "No two splits share a value of: street, vehicle." in card
    with (made[1] / "sequences.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["crossing.vehicle"] for row in rows] == ["sedan", "sedan", "van"]
    assert [row["crossing.lighting"] for row in rows] == ["day", "night", "day"]
    assert all(int(row["events.count"]) > 0 for row in rows)
    assert math.isclose(float(rows[0]["sensor.theta_on"]), made[0].sequences[0].sensor.theta_on)
    figure = read_image(made[1] / "overview.png")
    assert figure.shape[0] > 500


def test_tonic_reads_a_sequence_as_one_of_dsec(
    sequence: tuple[Crossing, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """tonic has folder names of its own, knows only the names of DSEC's recordings, and fetches a
    library to read PNG files, which OpenCV does here."""
    dsec = pytest.importorskip("tonic.datasets.dsec")
    freeimage = SimpleNamespace(download=lambda: None)
    plugins = SimpleNamespace(plugins=SimpleNamespace(freeimage=freeimage))
    monkeypatch.setitem(sys.modules, "imageio", plugins)
    monkeypatch.setattr(
        dsec.DSEC, "_read_16bit_png", lambda _, file: read_image(Path(file))[..., ::-1]
    )
    folder, name, flow = sequence[1], "thun_00_a", "optical_flow_forward"
    place = tmp_path / "DSEC" / name
    links = {
        "events_left": "events/left",
        "image_timestamps": "images",
        f"{flow}_event": "flow/forward",
    }
    for theirs in (*links, f"{flow}_timestamps"):
        (place / theirs).mkdir(parents=True)
        for file in (folder / links[theirs]).iterdir() if theirs in links else ():
            named = f"{name}_{theirs}.txt" if file.suffix == ".txt" else file.name
            (place / theirs / named).symlink_to(file)
    times = place / f"{flow}_timestamps" / f"{name}_{flow}_timestamps.txt"
    times.symlink_to(folder / "flow/forward_timestamps.txt")
    targets = [f"{flow}_event", f"{flow}_timestamps"]
    samples = dsec.DSEC(str(tmp_path), [name], ["events_left", "image_timestamps"], targets)
    ((events, image_times), (displacements, spans)) = samples[0]
    with h5py.File(folder / "events/left/events.h5") as file:
        for column in "txyp":
            assert (events["events_left"][column] == file[f"events/{column}"][:]).all()
        assert (events["ms_to_idx"] == file["ms_to_idx"][:]).all()
    assert image_times.tolist() == list(range(0, int(image_times[-1]) + 1, PERIOD_US))
    geometry = DenseTruth(sequence[0].scene, sequence[0].intrinsics)
    assert len(displacements) == len(spans) >= 4
    for read, span in zip(displacements, spans, strict=True):
        expected = geometry.displacement_px(*(sequence[0].seconds(int(t_us)) for t_us in span))
        valid = read[..., 2] == 1
        assert np.abs(read[..., :2] - expected)[valid].max() < 0.005
