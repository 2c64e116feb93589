import numpy as np

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import ApsFrame
from flybench.direction import Direction
from scenarios.study.snapshots import Album

GRID = np.zeros((4, 5), np.float32)
MAPS = FlyMaps(GRID, GRID, np.zeros((4, 4, 5), np.float32), GRID, GRID > 0, 3)


def frame(level: int) -> ApsFrame:
    return ApsFrame(0, level, np.full((12, 15), level, np.uint16))


def said(t_us: int) -> MotionEstimate:
    return MotionEstimate(t_us, 0.1, 0.0, Direction.RIGHT, 0.1, (1.0, 0.0), (7.0, 6.0), None)


def filled() -> Album:
    album = Album()
    album.add("fly", said(10_000), MAPS, None)  # before any frame
    for t_us in range(20_000, 1_000_001, 10_000):
        album.add_frames([frame(t_us // 10_000)] if t_us % 50_000 == 20_000 else [])
        album.add("fly", said(t_us), MAPS, (0, 0, 5, 5))
        album.add("wide", said(t_us), MAPS, None)
    return album


def test_moments_are_spread_over_the_crossing() -> None:
    shots = filled().choose((200_000, 700_000))
    assert [shot.t_us for shot in shots] == [300_000, 400_000, 440_000, 500_000, 600_000]
    assert all(shot.box_px == (0, 0, 5, 5) for shot in shots)  # the first fly's alone
    assert shots[0].aps[0, 0] == 27  # the frame that was the last at 300 ms


def test_none_is_chosen_twice_and_none_where_there_is_none() -> None:
    assert len(filled().choose((500_000, 510_000))) == 1
    assert Album().choose((0, 1)) == ()
    unseen = Album()
    unseen.add("fly", said(10_000), MAPS, None)
    assert unseen.choose((0, 1)) == ()
