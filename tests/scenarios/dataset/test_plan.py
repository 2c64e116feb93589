"""From the file of a dataset to its sequences, and files that are refused."""

from pathlib import Path

import pytest

from scenarios.dataset.draws import Draws
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.plan import DatasetPlan, read_plan
from scenarios.dataset.spec_file import DatasetSpecError
from scenarios.sweep.random_sample import UNIFORM, Distribution
from sim import Lighting
from sim.distractors import VehicleKind
from tests.scenarios.dataset.tiny import TINY, write_spec

EXAMPLES = Path(__file__).parents[3] / "scenarios" / "dataset" / "examples"
HEAD = 'title = "a"\nlicense = "MIT"\n'


def plan(tmp_path: Path, text: str) -> DatasetPlan:
    return read_plan(write_spec(tmp_path / "spec.toml", text))


def test_a_split_does_not_depend_on_the_size_of_another(tmp_path: Path) -> None:
    text = TINY.replace('disjoint = ["street", "vehicle"]', "")
    few, many = (plan(tmp_path, text.replace("train = 2", f"train = {n}")) for n in (1, 7))
    assert [s for s in many.sequences if s.split == "test"] == [few.sequences[-1]]
    assert many.sequences[0] == few.sequences[0]
    assert len({s.seed for s in many.sequences}) == 8
    assert len({s.crossing.distractors.seed for s in many.sequences}) == 8


def test_variants_take_turns_and_change_only_what_they_name(tmp_path: Path) -> None:
    sequences = plan(tmp_path, TINY.replace("train = 2", "train = 4")).sequences
    lights = [s.crossing.lighting for s in sequences if s.split == "train"]
    assert lights == [Lighting.DAY, Lighting.NIGHT] * 2
    plain = plan(tmp_path, TINY.replace("train = 2", "train = 4").split("[[variants]]")[0])
    assert [s.crossing.omega_rad_s for s in plain.sequences] == [
        s.crossing.omega_rad_s for s in sequences
    ]


def test_no_street_and_no_vehicle_is_in_two_splits(tmp_path: Path) -> None:
    text = TINY.replace("train = 2", "train = 30").replace("test = 1", "test = 30")
    text = text.replace(
        'distractors.pedestrian = "opposite"', 'distractors.far_vehicle = "opposite"'
    )
    sequences = plan(tmp_path, text).sequences
    train, test = ([s.crossing for s in sequences if s.split == name] for name in ("train", "test"))
    assert not {c.street_seed for c in train} & {c.street_seed for c in test}
    assert {c.vehicle for c in train} == {VehicleKind.SEDAN}
    assert {c.distractors.far_vehicle_kind for c in train} == {VehicleKind.SEDAN}
    assert {c.distractors.far_vehicle_kind for c in test} == {VehicleKind.VAN}


def test_sensors_come_from_presets_and_files(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('preset = "dvs128"\ntheta_on = 0.31\n')
    text = HEAD + '[splits]\na = 2\n[sensor]\nfile = "mine.toml"\nleak_hz = {uniform = [0.0, 0.2]}'
    made = plan(tmp_path, text)
    assert {(s.sensor_name, s.sensor.width, s.sensor.theta_on) for s in made.sequences} == {
        ("mine.toml", 128, 0.31)
    }
    assert len({s.sensor.leak_hz for s in made.sequences}) == 2
    choice = HEAD + '[splits]\na = 40\n[sensor]\npreset = {choice = ["davis240", "dvs128"]}'
    assert {s.sensor.width for s in plan(tmp_path, choice).sequences} == {240, 128}
    changed = text.replace("[sensor]", "[sensor]\ntheta_off = 0.4")
    assert plan(tmp_path, changed).sequences[0].key() != made.sequences[0].key()


def test_speeds_can_be_given_in_km_h(tmp_path: Path) -> None:
    text = HEAD + "[splits]\na = 20\n[crossing]\nspeed_km_h = {uniform = [20.0, 60.0]}\n"
    text += "distance_m = {uniform = [5.0, 12.0]}\n"
    made = plan(tmp_path, text).sequences
    speeds = [float(str(s.parameters()["crossing.speed_km_h"])) for s in made]
    assert len({s.crossing.omega_rad_s for s in made}) == 20
    assert 20 <= min(speeds) < 30 < 50 < max(speeds) <= 60
    for s, speed_km_h in zip(made, speeds, strict=True):
        assert speed_km_h / 3.6 == pytest.approx(s.crossing.omega_rad_s * s.crossing.distance)
    assert "crossing.speed_km_h" in made[0].drawn
    variant = text + '[[variants]]\nname = "slow"\ncrossing.omega_rad_s = 0.5'
    assert {s.crossing.omega_rad_s for s in plan(tmp_path, variant).sequences} == {0.5}


def test_labels_are_all_by_default_but_shards_and_frames_of_a_sensor_without(
    tmp_path: Path,
) -> None:
    text = HEAD + "[splits]\na = 1"
    by_default = [label for label in Label if label is not Label.SHARD]
    assert plan(tmp_path, text).spec.labels == tuple(by_default)
    frameless = plan(tmp_path, text + '\n[sensor]\npreset = "dvs128"').spec.labels
    assert set(by_default) - set(frameless) == {Label.APS}
    (tmp_path / "mine.toml").write_text('preset = "atis"')
    file = text + '\n[sensor]\nfile = "mine.toml"\n'
    assert plan(tmp_path, file).spec.labels == frameless
    with pytest.raises(DatasetSpecError, match=r"may be 'mine\.toml', which has no frames"):
        plan(tmp_path, file + '[labels]\nwanted = ["aps"]')


def test_a_change_of_the_sensor_replaces_its_source() -> None:
    file = Draws({"sensor.file": "a.toml", "crossing.lead_s": 0.1})
    preset = Draws({}, (Distribution("sensor.preset", "choice", ("dvs128",)),))
    assert file.with_changes(preset) == Draws({"crossing.lead_s": 0.1}, preset.drawn)
    seeds = Draws({}, (Distribution("seed", UNIFORM, (0, 1)),))
    assert seeds.with_changes(Draws({"seed": 3})) == Draws({"seed": 3})


def test_the_examples_are_valid() -> None:
    files = sorted(EXAMPLES.glob("*.toml"))
    assert files
    for file in files:
        assert read_plan(file).sequences


SPLITS = HEAD + "[splits]\ntrain = 2\ntest = 2\n"
BAD = {
    SPLITS + '[crossing]\ndirection = "none"': (
        r"crossing\.direction is 'none'\. Allowed is one of right, left, up, down"
    ),
    SPLITS + '[labels]\nwanted = [["flow"]]': r"labels\.wanted holds \['flow'\]\. Allowed is one",
    SPLITS + "[crossing]\nomega_rad_s = nan": r"crossing\.omega_rad_s is nan\. Allowed is a number",
    SPLITS + "[crossing]\nomega_rad_s = {uniform = [nan, 2.0]}": r"low below high\. Correct the",
    SPLITS + "[crossing]\nsun_elevation_deg = {uniform = [-10.0, 10.0]}": (
        r"crossing\.sun_elevation_deg is -10\.0\. Allowed is a number from 5 to 90 deg"
    ),
    SPLITS + '[crossing]\nprofile = "constant_omega"\nlead_s = 10.0': (
        r"sequence train/0000: crossing\.lead_s is 10: At t = .* Shorten lead_s"
    ),
    SPLITS + "[crossing]\nspeed_km_h = 40\nomega_rad_s = 1.0": (
        r"crossing\.omega_rad_s and crossing\.speed_km_h are both set\. Allowed is one of them"
    ),
    SPLITS + "[crossing]\nspeed_km_h = {uniform = [100.0, 300.0]}": (
        r"speed_km_h is 300, which is 12\.1 rad/s at .* 6\.89 m\. Allowed there is 1\.24 to 248 km"
    ),
    SPLITS + "[crossing]\nspeed_km_h = 600": r"crossing\.speed_km_h is 600\. Allowed is a number",
    "title": r"title is None\. Allowed is one line of text in quotes",
    HEAD: r"\[splits\] names no split\. Allowed is one split or more",
    HEAD + "splits = 3": r"splits is 3\. Allowed is a table\. Write \[splits\] above it",
    HEAD + "[splits]\ntrain = 0": r"splits\.train is 0\. Allowed is a whole number from 1",
    HEAD + "[splits]\nTrain = 1": r"splits\.Train is the name of a split\. Allowed are small",
    HEAD + "[splits]\ntrain = 900_000\ntest = 900_000": r"has 1,800,000 sequences in all\. Allowed",
    SPLITS + "[label]": r"There is no key label\. Allowed is .* Did you mean labels\?",
    SPLITS + "[labels]\nwant = []": r"There is no key labels\.want\. .* Did you mean wanted\?",
    SPLITS + '[labels]\nwanted = "flow"': r"labels\.wanted is 'flow'\. Allowed is a list of flow",
    SPLITS + '[labels]\nwanted = ["flows"]': r"labels\.wanted holds 'flows'\. Allowed is one of",
    SPLITS + '[labels]\nwanted = ["flow", "flow"]': r"holds 'flow' twice\. Allowed is once",
    SPLITS + '[labels]\nwanted = ["disparity"]': r"holds 'disparity'\. The scene has one camera",
    SPLITS + '[labels]\nwanted = ["coco"]': r"holds 'coco' without 'images'\. .* Add 'images'",
    SPLITS + '[labels]\nwanted = ["aps"]\n[sensor]\npreset = "dvs128"': (
        r"holds 'aps', and the sensor may be 'dvs128', which has no frames\. Remove 'aps'"
    ),
    SPLITS + "[labels]\nperiod_ms = 0": r"labels\.period_ms is 0\. Allowed is a whole number from",
    SPLITS + "[crossing]\nomega = 1": r"no parameter crossing\.omega\. Similar names",
    SPLITS + "[crossing]\nomega_rad_s = {uniform = [2, 1]}": (
        r"crossing\.omega_rad_s is .*\. Allowed is \{uniform = \[low, high\]\} with low below high"
    ),
    SPLITS + "[crossing]\nomega_rad_s = {normal = [2, 1]}": (
        r"Allowed in \[crossing\] is \{uniform"
    ),
    SPLITS + "[crossing]\nomega_rad_s = {uniform = [1, 11]}": (
        r"crossing\.omega_rad_s is 11\.0\. Allowed is a number from 0\.05 to 10 rad/s"
    ),
    SPLITS + '[crossing]\nvehicle = "bus"': r"crossing\.vehicle is 'bus'\. Allowed is one of",
    SPLITS + '[sensor]\nfile = "none.toml"': r"sensor\.file is 'none\.toml': .* cannot be read",
    SPLITS + "[sensor]\nfile = {uniform = [1, 2]}": r"sensor\.file is .* List the files",
    SPLITS + '[sensor]\nfile = "x.toml"\npreset = "dvs128"': r"are both set\. Allowed is one of",
    HEAD + "variants = 3\n[splits]\na = 1": r"variants is 3\. Allowed is one table per variant",
    SPLITS + "[[variants]]\nname = 3": r"variants\.name is 3\. Allowed is text in quotes",
    SPLITS + '[[variants]]\nname = "a"\nlead_s = 3': r"There is no key variants\.lead_s\.",
    HEAD + 'disjoint = ["street"]\n[splits]\na = 1': r"There is no key disjoint\.",
    HEAD + '[splits]\na = 1\nb = 1\ndisjoint = ["vehicle"]': (
        r"disjoint holds 'vehicle', and crossing\.vehicle is not drawn\. .* Write crossing\.vehicle"
    ),
    HEAD
    + '[splits]\na = 1\nb = 1\ndisjoint = ["vehicle"]\n[crossing]\nvehicle = {choice = ["van"]}': (
        r"1 different values for 2 splits\. Allowed is one value or more for each split"
    ),
    HEAD
    + '[splits]\na = 1\nb = 1\ndisjoint = ["vehicle"]\n[crossing]\n'
    + 'vehicle = {choice = ["van", "sedan"]}\ndistractors.far_vehicle_kind = "van"': (
        r"far_vehicle_kind is set\. It is then drawn from the vehicles of each split\. Remove"
    ),
    HEAD
    + '[splits]\na = 1\nb = 1\ndisjoint = ["street"]\n'
    + '[[variants]]\nname = "v"\ncrossing.street_seed = 3': r"street_seed is in \[\[variants\]\]",
    SPLITS
    + '[crossing]\ndistance_m = 3.5\ndistractors.pedestrian = "same"\n'
    + 'distractors.pedestrian_pavement = "near"': r"crossing\.distance_m is 3\.5 and a pedestrian",
    HEAD + "[splits]\na = 1\n[sensor]\nwidth = 20000\nheight = 20000": r"needs .* GB of memory",
}


@pytest.mark.parametrize("text", BAD)
def test_a_bad_file_is_refused_with_file_key_value_and_remedy(text: str, tmp_path: Path) -> None:
    source = "license = 'MIT'" if text == "title" else text
    with pytest.raises(DatasetSpecError, match=BAD[text]) as caught:
        plan(tmp_path, source)
    assert str(caught.value).startswith(f"{tmp_path / 'spec.toml'}: ")
