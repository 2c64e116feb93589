import numpy as np

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import ApsFrame
from flybench.direction import Direction
from scenarios.study.snapshots import SnapshotCollector

GRID = np.zeros((4, 5), np.float32)
MAPS = FlyMaps(GRID, GRID, np.zeros((4, 4, 5), np.float32), GRID, GRID > 0, 3)


def frame(level: int) -> ApsFrame:
    return ApsFrame(0, level, np.full((12, 15), level, np.uint16))


def estimate(t_us: int) -> MotionEstimate:
    return MotionEstimate(t_us, 0.1, 0.0, Direction.RIGHT, 0.1, (1.0, 0.0), (7.0, 6.0), None)


def filled_collector() -> SnapshotCollector:
    collector = SnapshotCollector()
    collector.add("fly", estimate(10_000), MAPS, None)  # before the first frame
    for t_us in range(20_000, 1_000_001, 10_000):
        collector.add_frames([frame(t_us // 10_000)] if t_us % 50_000 == 20_000 else [])
        collector.add("fly", estimate(t_us), MAPS, (0, 0, 5, 5))
        collector.add("wide", estimate(t_us), MAPS, None)
    return collector


def test_snapshots_are_spread_over_the_crossing() -> None:
    shots = filled_collector().select((200_000, 700_000))
    assert [shot.t_us for shot in shots] == [300_000, 400_000, 440_000, 500_000, 600_000]
    assert all(shot.box_px == (0, 0, 5, 5) for shot in shots)  # only the first fly counts
    assert shots[0].aps[0, 0] == 27  # the last frame at 300 ms


def test_a_snapshot_is_selected_only_once() -> None:
    assert len(filled_collector().select((500_000, 510_000))) == 1


def test_without_frames_there_are_no_snapshots() -> None:
    collector = SnapshotCollector()
    assert collector.select((0, 1)) == ()
    collector.add("fly", estimate(10_000), MAPS, None)
    assert collector.select((0, 1)) == ()
