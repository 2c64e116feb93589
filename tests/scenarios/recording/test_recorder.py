"""A small recording, written and read back."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import Cause
from scenarios.errors import ScenarioError
from scenarios.recording import Recorder
from scenarios.recording.blueprint import blueprint, stream_blueprint
from scenarios.recording.entities import TRUE_DIRECTION, paths_of
from scenarios.recording.event_batches import class_id
from scenarios.styles.method_style import method_style
from sim import Crossing, CrossingConfig, GroundTruth, project
from sim.truth.probe import TruthProbe
from tests.scenarios.rrd_contents import RrdContents
from tests.scenarios.timed_events import events_at
from tests.sim.body_labels import target_body_labels

CELL_PX = 3
METHODS = ("fly", "plane-fit", "mine:Own")
FLY, PLANE_FIT, OWN = (paths_of(method, n) for n, method in enumerate(METHODS))
MAPS = (FLY.saliency, FLY.on, FLY.off, *FLY.motion)
PARAMETERS = {
    "seed": 3,
    "crossing.lighting": "day",
    "crossing.lux": 3e4,
    "crossing.noise": True,
    "crossing.nothing": None,
}


def truth_at(crossing: Crossing, t_us: int, *, visible: bool = True) -> GroundTruth:
    mask = np.zeros((260, 346), np.bool_)
    if visible:
        mask[120:150, 100:140] = True
    probe = TruthProbe(crossing.scene, crossing.intrinsics)
    return probe.measure(t_us, crossing.seconds(t_us), target_body_labels(mask, crossing.scene))


def jpeg(rgb: tuple[int, int, int]) -> bytes:
    picture = np.full((520, 692, 3), rgb[::-1], np.uint8)
    return cv2.imencode(".jpg", picture)[1].tobytes()


def estimate_at(t_us: int, hs: float, direction: Direction) -> MotionEstimate:
    roi = None if direction is Direction.NONE else (90, 90, 150, 150)
    return MotionEstimate(t_us, hs, -0.25, direction, abs(hs), (hs, -0.25), (120.0, 130.0), roi)


def maps_of(level: float) -> FlyMaps:
    grid = np.full((87, 116), level, np.float32)
    motion = np.stack([grid, grid / 2, grid / 4, grid / 8])
    return FlyMaps(grid, 2 * grid, motion, grid, grid > 0, CELL_PX)


@pytest.fixture(scope="module")
def crossing() -> Crossing:
    return Crossing(CrossingConfig(direction=Direction.UP))


@pytest.fixture(scope="module")
def path(crossing: Crossing, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "recording.rrd"
    with Recorder(
        path, crossing=crossing, parameters=PARAMETERS, methods=METHODS, maps_of="fly"
    ) as recorder:
        causes = np.array([Cause.SIGNAL, Cause.SIGNAL, Cause.SHOT], np.uint8)
        recorder.log_events(events_at(1_200, 1_900, 1_950), causes)
        recorder.log_events(events_at(1_999, 5_000))
        recorder.log_aps(ApsFrame(0, 7_200, np.full((260, 346), 680, np.uint16)))
        half = crossing.duration_us // 2
        recorder.log_preview(jpeg((200, 100, 50)), truth_at(crossing, half), scale=2.0)
        recorder.log_truth(truth_at(crossing, 0, visible=False))
        recorder.log_truth(truth_at(crossing, half))
        for method, maps in (
            ("plane-fit", None),
            ("fly", maps_of),
        ):
            for t_us, hs, direction in (
                (10_000, 0.0, Direction.NONE),
                (20_000, 0.5, Direction.RIGHT),
                (30_000, 0.75, Direction.RIGHT),
            ):
                estimate = estimate_at(t_us, hs, direction)
                shown = None if maps is None or t_us == 30_000 else maps(hs)
                recorder.log_estimate(method, estimate, shown)
        recorder.log_estimate("mine:Own", estimate_at(15_000, -0.5, Direction.LEFT))
    return path


@pytest.fixture(scope="module")
def contents(path: Path) -> RrdContents:
    return RrdContents(path)


def test_events_are_grouped_into_milliseconds(contents: RrdContents) -> None:
    assert contents.rows("/world/camera/events", "Points2D:positions") == [
        (0.002, [[0.5, 7.5], [1.5, 7.5], [2.5, 7.5], [0.5, 7.5]]),
        (0.006, [[1.5, 7.5]]),
    ]


def test_the_class_of_an_event_shows_polarity_and_cause(contents: RrdContents) -> None:
    classes = contents.values("/world/camera/events", "Points2D:class_ids")
    assert classes == [[1, 0, class_id(Cause.SHOT, on=True), 1], [0]]
    legend = contents.static("/world/camera/events", "AnnotationContext:context")[0]
    labels = {entry["class_id"]: entry["class_description"]["info"]["label"] for entry in legend}
    assert len(labels) == 2 * len(Cause)
    assert [labels[k] for k in classes[0]] == ["ON", "OFF", "ON, shot", "ON"]


def test_event_rates_have_one_row_per_millisecond(
    contents: RrdContents, crossing: Crossing
) -> None:
    on, off, noise = (
        dict(contents.rows(f"/event_rate/{kind}", "Scalars:scalars"))
        for kind in ("on", "off", "noise")
    )
    assert len(on) == crossing.duration_us // 1000 + 2
    assert (on[0.001], on[0.002], on[0.006]) == ([0.0], [3.0], [0.0])
    assert (off[0.002], off[0.006], noise[0.002]) == ([1.0], [1.0], [1.0])


def test_each_method_has_its_responses_and_decisions(contents: RrdContents) -> None:
    for method in (FLY, PLANE_FIT):
        hs = contents.rows(f"/{method.hs}", "Scalars:scalars")
        assert hs == [(0.01, [0.0]), (0.02, [0.5]), (0.03, [0.75])]
        assert contents.values(f"/{method.vs}", "Scalars:scalars") == [[-0.25]] * 3
        decisions = contents.rows(f"/{method.direction}", "StateChange:state")
        assert decisions == [(0.01, [""]), (0.02, ["right"])]
    assert contents.rows(f"/{OWN.direction}", "StateChange:state") == [(0.015, ["left"])]


def test_the_velocity_of_a_method_is_plotted_with_the_true_one(contents: RrdContents) -> None:
    right = contents.values("/velocity/image/x/plane-fit", "Scalars:scalars")
    assert right == [[0.0], [0.5], [0.75]]
    assert contents.values("/velocity/image/y/plane-fit", "Scalars:scalars") == [[-0.25]] * 3
    assert contents.rows("/velocity/image/x/fly", "Scalars:scalars") == []


def test_lanes_are_sorted_with_the_truth_first() -> None:
    lanes = [TRUE_DIRECTION, FLY.direction, PLANE_FIT.direction, OWN.direction]
    assert lanes == sorted(lanes)


def test_curves_of_several_methods_have_their_names(contents: RrdContents) -> None:
    names = [contents.static(f"/{m.hs}", "SeriesLines:names") for m in (FLY, PLANE_FIT, OWN)]
    assert names == [[method_style(method).label] for method in METHODS]
    for paths, method in zip((FLY, PLANE_FIT, OWN), METHODS, strict=True):
        (colour,) = contents.static(f"/{paths.hs}", "SeriesLines:colors")
        assert f"#{colour:08X}" == f"{method_style(method).colour}FF"


def test_the_true_direction_and_velocity_are_recorded(
    contents: RrdContents, crossing: Crossing
) -> None:
    omega_rad_s = crossing.config.omega_rad_s
    assert contents.values(f"/{TRUE_DIRECTION}", "StateChange:state") == [[""], ["up"]]
    angular = contents.values("/velocity/angular", "Scalars:scalars")
    assert angular[-1] == pytest.approx([omega_rad_s], rel=1e-4)
    downward = contents.values("/velocity/image/y/truth", "Scalars:scalars")
    assert downward[-1] == pytest.approx([-omega_rad_s * crossing.intrinsics.focal_px], rel=1e-4)


def test_the_true_box_is_shown_while_the_target_is_visible(contents: RrdContents) -> None:
    truth = "/world/camera/truth"
    assert contents.values(f"{truth}/box", "Boxes2D:centers") == [[], [[120.0, 135.0]]]
    assert contents.values(f"{truth}/box", "Boxes2D:half_sizes") == [[], [[20.0, 15.0]]]


def test_a_preview_has_mask_box_and_centroid_of_its_time(
    contents: RrdContents, crossing: Crossing
) -> None:
    truth, half_s = "/world/camera/truth", crossing.duration_us // 2 / 1e6
    assert [t for t, _ in contents.rows("/world/camera/preview", "EncodedImage:blob")] == [half_s]
    ((t_s, (mask,)),) = contents.rows(f"{truth}/mask", "SegmentationImage:buffer")
    assert (t_s, sum(mask)) == (half_s, 40 * 30)
    boxes = contents.rows(f"{truth}/preview_box", "Boxes2D:centers")
    assert boxes == [(half_s, [[120.0, 135.0]])]
    centroids = contents.rows(f"{truth}/preview_centroid", "Points2D:positions")
    assert centroids == [(half_s, [[120.0, 135.0]])]


def test_region_and_view_centre_are_in_sensor_pixels(contents: RrdContents) -> None:
    for method in (FLY, PLANE_FIT):
        rois = contents.values(f"/{method.roi}", "Boxes2D:centers")
        assert rois == [[], *[[[120.0, 120.0]]] * 2]
        centres = contents.values(f"/{method.view_centre}", "Points2D:positions")
        assert centres == [[[120.0, 130.0]]] * 3


def test_maps_are_scaled_to_the_sensor_and_to_a_common_brightness(contents: RrdContents) -> None:
    for entity in MAPS:
        assert contents.static(f"/{entity}", "Transform3D:scale") == [[CELL_PX, CELL_PX, 1.0]]
        assert len(contents.rows(f"/{entity}", "DepthImage:buffer")) == 2
    brightest = {
        entity: contents.static(f"/{entity}", "DepthImage:depth_range")[0][1] for entity in MAPS
    }
    assert brightest[FLY.on] == brightest[FLY.off] == 1.0
    assert {brightest[entity] for entity in FLY.motion} == {0.5}


def test_maps_keep_their_values(contents: RrdContents) -> None:
    (_, second) = contents.values(f"/{FLY.motion[1]}", "DepthImage:buffer")
    left = np.array(second[0], np.uint8).view(np.float16)
    np.testing.assert_array_equal(left, np.full(87 * 116, 0.25))


def test_frames_keep_their_levels_and_appear_at_the_end_of_exposure(contents: RrdContents) -> None:
    ((t_s, buffer),) = contents.rows("/world/camera/aps", "Image:buffer")
    assert t_s == 0.0072
    np.testing.assert_array_equal(np.array(buffer[0], np.uint8).view(np.uint16), 680)


def test_a_preview_keeps_its_colours_and_covers_the_sensor(contents: RrdContents) -> None:
    ((_, blob),) = contents.rows("/world/camera/preview", "EncodedImage:blob")
    bgr = cv2.imdecode(np.array(blob[0], np.uint8), cv2.IMREAD_COLOR)
    assert bgr is not None
    np.testing.assert_allclose(bgr[100, 100], [50, 100, 200], atol=4)
    assert contents.static("/world/camera/preview", "Transform3D:scale") == [[0.5, 0.5, 1.0]]


def test_the_camera_projects_like_the_simulators_camera(
    contents: RrdContents, crossing: Crossing
) -> None:
    camera = "/world/camera"
    position = np.array(contents.static(camera, "Transform3D:translation")[0])
    axes = np.array(contents.static(camera, "Transform3D:mat3x3")[0]).reshape(3, 3).T
    pinhole = np.array(contents.static(camera, "Pinhole:image_from_camera")[0]).reshape(3, 3).T
    points_m = np.array([[0.0, 0.0, 1.0], [2.0, -0.9, 0.3], [-3.0, 4.0, 2.0]])
    homogeneous = (points_m - position) @ axes @ pinhole.T
    expected_px, _ = project(points_m, crossing.scene.pose, crossing.intrinsics)
    np.testing.assert_allclose(homogeneous[:, :2] / homogeneous[:, 2:], expected_px, atol=0.01)


def test_the_vehicle_moves_and_its_wheels_turn(contents: RrdContents, crossing: Crossing) -> None:
    start, middle = contents.values("/world/vehicle/sedan", "Transform3D:translation")
    assert middle[0] == pytest.approx([0, 0, 0], abs=1e-3)
    assert start[0] == pytest.approx([crossing.position_m(0), 0, 0], abs=1e-3)
    wheel = contents.values("/world/vehicle/wheel_rear_left", "Transform3D:mat3x3")
    assert np.abs(np.subtract(*wheel)).max() > 0.1


def test_every_body_has_a_mesh(contents: RrdContents) -> None:
    for entity in ("/world/street", "/world/vehicle/sedan", "/world/vehicle/wheel_front_left"):
        vertices = contents.static(entity, "Mesh3D:vertex_positions")
        assert len(vertices) == len(contents.static(entity, "Mesh3D:vertex_colors")) > 100


def test_parameters_are_properties_of_the_recording(contents: RrdContents) -> None:
    assert contents.static("/__properties/run", "seed") == [3.0]
    assert contents.static("/__properties/crossing", "lighting") == ["day"]
    assert contents.static("/__properties/crossing", "lux") == [3e4]
    assert contents.static("/__properties/crossing", "noise") == [True]


def test_a_recording_has_one_time_line_and_one_blueprint(path: Path, contents: RrdContents) -> None:
    assert {name for chunk in contents.chunks for name in chunk.timeline_names} == {"time"}
    assert len(rr.chunk.RrdReader(path).blueprints()) == 1


def test_the_default_name_is_lighting_speed_and_direction(contents: RrdContents) -> None:
    name = contents.static("/__properties", "RecordingInfo:name")
    assert name == ["day, 1.61 rad/s, up"]


def views(crossing: Crossing, *methods: str, maps_of: str | None = None) -> str:
    paths = {method: paths_of(method, n) for n, method in enumerate(methods)}
    return str(list(_views(blueprint(crossing, paths, maps_of).root_container)))


def test_without_maps_there_are_no_views_for_them(crossing: Crossing) -> None:
    assert "ON surface" in views(crossing, "fly", maps_of="fly")
    assert "surface" not in views(crossing, "plane-fit")
    assert "Events of" in views(crossing, "plane-fit")
    assert "Events of" in views(crossing)


def test_without_truth_there_are_no_views_for_it() -> None:
    paths = {"plane-fit": paths_of("plane-fit", 0)}
    view = stream_blueprint(640, 480, paths, has_frames=False)
    names = str(list(_views(view.root_container)))
    assert "Events of" in names
    assert "Image velocity" in names
    for word in ("true", "truth", "Scene", "Preview", "APS", "Angular"):
        assert word not in names
    assert "APS" in str(
        list(_views(stream_blueprint(640, 480, paths, has_frames=True).root_container))
    )


def test_several_methods_share_one_plot_per_axis(
    crossing: Crossing,
) -> None:
    assert "Response of the detector" in views(crossing, "fly")
    several = views(crossing, "fly", "wide")
    assert 0 < several.index("VS response") < several.index("HS response")


def test_without_velocity_estimates_the_event_rate_comes_first(crossing: Crossing) -> None:
    without, with_velocity = views(crossing, "fly"), views(crossing, "fly", "plane-fit")
    assert without.index("Event rate") < without.index("Image velocity")
    assert with_velocity.index("Image velocity") < with_velocity.index("Event rate")


@pytest.mark.parametrize(
    ("methods", "maps_of", "words"),
    [
        (("fly", "fly"), None, "fly is recorded twice"),
        (("fly",), "wide", r"maps are of wide\. Allowed is one of .* \(fly\)"),
        ((), "wide", "there are none"),
    ],
)
def test_invalid_methods_are_refused(
    crossing: Crossing, tmp_path: Path, methods: tuple[str, ...], maps_of: str | None, words: str
) -> None:
    file = tmp_path / "a.rrd"
    with pytest.raises(ScenarioError, match=words):
        Recorder(file, crossing=crossing, parameters={}, methods=methods, maps_of=maps_of)
    assert not file.exists()


def _views(container: Any) -> Iterator[str]:
    for part in container.contents:
        if hasattr(part, "contents") and not isinstance(part, rrb.View):
            yield from _views(part)
        else:
            yield str(part.name)


def test_an_empty_recording_is_a_complete_file(crossing: Crossing, tmp_path: Path) -> None:
    file = tmp_path / "empty.rrd"
    with Recorder(file, crossing=crossing, parameters={}):
        pass
    rates = RrdContents(file).values("/event_rate/on", "Scalars:scalars")
    assert set(map(tuple, rates)) == {(0.0,)}


def test_a_file_that_cannot_be_written_raises_an_error(crossing: Crossing, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere"):
        Recorder(tmp_path / "nowhere" / "a.rrd", crossing=crossing, parameters={})
