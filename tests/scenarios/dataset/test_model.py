"""Datasets of a MuJoCo model with a camera and a trajectory, in place of a street."""

import csv
import json
import math
from functools import partial
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest

from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.plan import DatasetPlan, read_plan
from scenarios.dataset.run import run_dataset
from scenarios.dataset.size import duration_s
from scenarios.dataset.spec_file import DatasetSpecError
from scenarios.datasets import EventDataset
from scenarios.errors import ScenarioError
from scenarios.pipeline.parallel import run_locally
from tests.scenarios.dataset.tiny import write_spec

MODEL = """
<mujoco>
  <asset><texture name="checks" type="2d" builtin="checker" rgb1=".8 .8 .8" rgb2=".1 .1 .1"
    width="64" height="64"/><material name="checks" texture="checks" texrepeat="3 3"/></asset>
  <worldbody>
    <camera name="eye" pos="0 0 4" fovy="45"/>
    <light type="directional" dir="0 0 -1" diffuse="1 1 1" intensity="1000"/>
    <geom type="plane" size="9 9 .1" rgba=".3 .3 .3 1"/>
    <body name="box" pos="0 0 1"><joint type="slide" axis="1 0 0"/>
      <geom type="box" size=".5 .4 .2" material="checks"/></body>
    {more}
  </worldbody>
  {rest}
</mujoco>
"""
KEYS = '<keyframe><key time="0" qpos="-.5"/><key time=".12" qpos=".5"/></keyframe>'
MOTION = """
def swing(model, seed, speed_m_s):
    def place(data, t_s):
        data.qpos[0] = speed_m_s * (t_s - 0.05)
    return place

def broken(model, seed):
    return lambda data, t_s: 1 / 0

def wrong(model, seed):
    return 3
"""
SPEC = """
title = "Box"
license = "MIT"
[splits]
train = 1
[labels]
period_ms = 40
wanted = ["flow", "velocity", "depth", "masks", "boxes", "coco", "event_source", "event_flow",
          "camera", "aps", "images", "shard"]
[sensor]
width = 64
height = 48
[model]
file = "box.xml"
camera = "eye"
step_px = 2.0
supersample = 1
"""
BY_KEYFRAMES = SPEC + 'trajectory = "keyframes"\n'
BY_FUNCTION = SPEC + 'trajectory = "motion.py:swing"\nduration_s = 0.1\n'
SPEEDS = "arguments.speed_m_s = {uniform = [4.0, 8.0]}\n"
SPEED_PX_S = 24 / math.tan(math.radians(45) / 2) * (1 / 0.12) / 2.8


def write_model(folder: Path, more: str = "", rest: str = KEYS) -> None:
    (folder / "box.xml").write_text(MODEL.format(more=more, rest=rest))
    (folder / "motion.py").write_text(MOTION)


def plan_of(folder: Path, text: str) -> DatasetPlan:
    return read_plan(write_spec(folder / "box.toml", text))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the dataset of a box that slides to the right."""
    folder = tmp_path_factory.mktemp("model")
    write_model(folder)
    run_dataset(plan_of(folder, BY_KEYFRAMES), folder / "out", partial(run_locally, jobs=1))
    return folder / "out"


def test_labels_are_those_of_the_motion(made: Path) -> None:
    folder = made / "train/0000"
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["duration_us"] == 120_000
    assert summary["objects"] == [{"track_id": 0, "name": "box", "kind": "box"}]
    assert summary["image_speed_px_s"] == pytest.approx(SPEED_PX_S, rel=1e-4)
    mask = cv2.imread(str(folder / "masks/000001.png"), cv2.IMREAD_UNCHANGED)
    depth = cv2.imread(str(folder / "depth/000001.png"), cv2.IMREAD_UNCHANGED)
    flow = cv2.imread(str(folder / "flow/forward/000001.png"), cv2.IMREAD_UNCHANGED)
    assert mask is not None
    assert depth is not None
    assert flow is not None
    on_box = mask == 1
    assert 100 < on_box.sum() < 800
    assert depth[on_box] / 256 == pytest.approx(2.8, abs=0.003)
    assert depth[~on_box] / 256 == pytest.approx(4.0, abs=0.003)
    moved_px = (flow[..., 2].astype(float) - 2**15) / 128  # OpenCV returns blue, green, red
    assert moved_px[on_box] == pytest.approx(SPEED_PX_S * 0.04, abs=0.005)
    assert (moved_px[~on_box] == 0).all()
    with h5py.File(folder / "flow/velocity.h5") as file:
        velocity = file["velocity_px_s"][1]
    assert velocity[on_box, 0] == pytest.approx(SPEED_PX_S, rel=1e-4)
    image = cv2.imread(str(folder / "images/left/distorted/000001.png"))
    assert image is not None
    assert image[on_box].std() > 20


def test_events_of_the_box_have_its_number_and_its_flow(made: Path) -> None:
    with h5py.File(made / "train/0000/events/left/event_labels.h5") as file:
        source, cause, flow = (file[name][:] for name in ("source", "cause", "flow_px_s"))
    signal = cause == 0
    assert np.count_nonzero(source == 0) > 0.95 * np.count_nonzero(signal) > 500
    assert flow[source == 0, 0] == pytest.approx(SPEED_PX_S, rel=1e-3)
    assert (source[~signal] == -2).all()


def test_boxes_have_classes_of_their_own(made: Path) -> None:
    tracks = np.load(made / "train/0000/object_detections/left/tracks.npy")
    assert set(tracks["class_id"]) == {8}
    assert tracks["t"].tolist() == [0, 40_000, 80_000, 120_000]
    assert (np.diff(tracks["x"]) > 0).all()
    document = json.loads((made / "annotations_train.json").read_text())
    assert {"id": 101, "name": "box"} in document["categories"]
    assert {entry["category_id"] for entry in document["annotations"]} == {101}


def test_the_camera_and_the_table_are_those_of_the_model(made: Path) -> None:
    with (made / "train/0000/poses.csv").open(newline="") as file:
        poses = list(csv.DictReader(file))
    assert len(poses) == 121
    assert [float(poses[9][axis]) for axis in ("x_m", "y_m", "z_m")] == pytest.approx([0, 0, 4])
    text = (made / "train/0000/calibration/cam_to_cam.yaml").read_text()
    assert f"camera_matrix: [{24 / math.tan(math.radians(45) / 2):.4f}"[:20] in text
    with (made / "sequences.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["model.file"], row["model.trajectory"], row["direction"]) == (
        "box.xml",
        "keyframes",
        "",
    )
    assert "in which a MuJoCo model moves" in (made / "README.md").read_text()


def test_training_reads_the_labels_of_a_model(made: Path) -> None:
    samples = EventDataset(made, window_us=40_000, labels=["flow", "boxes", "masks"])
    assert len(samples) == 2
    assert samples[0]["boxes"]["track_id"].tolist() == [0]
    with pytest.raises(ScenarioError, match="labels holds 'motion'"):
        EventDataset(made, window_us=40_000, labels=["motion"])


def test_arguments_of_a_function_are_drawn(tmp_path: Path) -> None:
    write_model(tmp_path, rest="")
    text = BY_FUNCTION.replace("train = 1", "train = 3") + SPEEDS
    plan = plan_of(tmp_path, text)
    speeds = [s.parameters()["model.arguments.speed_m_s"] for s in plan.sequences]
    assert len(set(speeds)) == 3
    assert all(isinstance(speed, float) and 4 <= speed <= 8 for speed in speeds)
    assert len({s.parameters()["model.seed"] for s in plan.sequences}) == 3
    assert [duration_s(s) for s in plan.sequences] == pytest.approx([0.1] * 3)
    first = plan.sequences[0]
    velocity = first.build_scene().velocity_px_s(50_000)
    assert velocity.max() == pytest.approx(SPEED_PX_S * 0.12 * float(str(speeds[0])), rel=1e-4)


def test_a_change_of_the_model_or_the_function_makes_other_sequences(tmp_path: Path) -> None:
    write_model(tmp_path, rest="")
    text = BY_FUNCTION + SPEEDS
    before = plan_of(tmp_path, text).sequences[0]
    write_model(tmp_path, rest="", more='<geom size=".1"/>')
    after = plan_of(tmp_path, text).sequences[0]
    assert before.key() != after.key()
    with pytest.raises(ScenarioError, match=r"box\.xml, or the trajectory .* has changed since"):
        before.build_scene()


def test_all_labels_but_motion_are_the_default(tmp_path: Path) -> None:
    write_model(tmp_path)
    lines = [
        line for line in BY_KEYFRAMES.splitlines() if "event" not in line and "aps" not in line
    ]
    labels = plan_of(tmp_path, "\n".join(lines)).spec.labels
    assert set(Label) - set(labels) == {Label.MOTION, Label.SHARD}


FLEX = """<tendon><spatial name="cord" width=".05"><site site="a"/><site site="b"/></spatial>
  </tendon>"""
SITES = '<site name="a" pos="0 0 1"/><site name="b" pos="1 0 1"/>'
BAD = [
    (SPEC, r"model\.trajectory is missing\. Allowed is text in quotes"),
    (BY_KEYFRAMES.replace('file = "box.xml"', ""), r"model\.file is missing"),
    (BY_KEYFRAMES.replace("box.xml", "bix.xml"), r"cannot open .*bix\.xml"),
    (BY_KEYFRAMES.replace('"eye"', '"ear"'), r"no camera 'ear'\. Allowed is one of 'eye'"),
    (BY_KEYFRAMES + "duration_s = 1.0", r'model\.duration_s is set, and the trajectory is "keyfr'),
    (BY_KEYFRAMES + "speed = 1.0", r"There is no key model\.speed\. Allowed is file, .* Did you"),
    (BY_KEYFRAMES + 'light = "noon"', r"there is no light 'noon'\. Allowed are 'daylight'"),
    (BY_KEYFRAMES + 'objects = ["bix"]', r"no body 'bix' that can move\. Allowed is one of box"),
    (BY_KEYFRAMES + "objects = 3", r"model\.objects is 3\. Allowed is a list of names"),
    (
        BY_KEYFRAMES + "max_step_ms = 99.0",
        r"model\.max_step_ms is 99\.0\. Allowed is a number from",
    ),
    (BY_KEYFRAMES + "[crossing]\nlead_s = 0.1", r"crossing\.lead_s is set, and \[model\] names"),
    (BY_KEYFRAMES.replace("height = 48", "focal_length_mm = 8.0"), r"field of view is that of the"),
    (BY_KEYFRAMES.replace('"camera", ', '"motion", '), r"holds 'motion', and the scene is a model"),
    (
        BY_KEYFRAMES.replace("train = 1", 'train = 1\ndisjoint = ["street"]'),
        r"holds 'street', and the scene is a model",
    ),
    (BY_FUNCTION, r"cannot be called with \(model, seed=\.\.\., \): missing .* 'speed_m_s'"),
    (BY_FUNCTION.replace("duration_s = 0.1", ""), r"model\.duration_s is missing, and the traj"),
    (BY_FUNCTION.replace("swing", "swung") + SPEEDS, r"has no function swung\. Allowed is one of "),
    (BY_FUNCTION.replace("motion.py", "none.py"), r"names none\.py, which cannot be imported: Fi"),
    (BY_FUNCTION.replace("motion.py:", "motion."), r'is .motion\.swing.\. Allowed is "keyframes",'),
    (BY_FUNCTION.replace("swing", "broken"), r"which fails: ZeroDivisionError: .*motion\.py, line"),
    (BY_FUNCTION.replace("swing", "wrong"), r"which returns 3\. Allowed is a function place"),
    (BY_FUNCTION + "arguments.speed_m_s = nan", r"arguments\.speed_m_s is nan\. Allowed is a fin"),
    (BY_FUNCTION + "arguments = 3", r"model\.arguments is 3\. Allowed is a table"),
    (BY_FUNCTION + "arguments.a-b = 3", r"model\.arguments\.a-b is no name of an argument"),
]


@pytest.mark.parametrize(("text", "message"), BAD, ids=[message[:30] for _, message in BAD])
def test_a_bad_model_is_refused_before_anything_is_rendered(
    text: str, message: str, tmp_path: Path
) -> None:
    write_model(tmp_path)
    with pytest.raises(DatasetSpecError, match=message) as caught:
        plan_of(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path / 'box.toml'}: ")


def test_labels_that_the_model_cannot_give_are_refused(tmp_path: Path) -> None:
    write_model(tmp_path, more=SITES, rest=KEYS + FLEX)
    with pytest.raises(
        DatasetSpecError, match=r"wanted holds 'flow', and the model box\.xml has the"
    ):
        plan_of(tmp_path, BY_KEYFRAMES)
    lines = [line for line in BY_KEYFRAMES.splitlines() if "wanted" not in line]
    text = "\n".join(lines).replace('"camera", "aps"', 'wanted = ["camera", "aps"')
    assert plan_of(tmp_path, text).sequences


def test_a_model_without_light_needs_one(tmp_path: Path) -> None:
    write_model(tmp_path)
    path = tmp_path / "box.xml"
    path.write_text(path.read_text().replace('intensity="1000"', ""))
    with pytest.raises(DatasetSpecError, match=r"none of the model's 1 lights has an intensity"):
        plan_of(tmp_path, BY_KEYFRAMES)
    assert plan_of(tmp_path, BY_KEYFRAMES + 'light = "daylight"').sequences
