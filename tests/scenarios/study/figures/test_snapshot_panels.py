import numpy as np
from matplotlib.figure import Figure

from scenarios.study.figures.snapshot_panels import (
    draw_aps,
    draw_saliency,
    sample_snapshot,
    white_dn,
)
from tests.scenarios.study.hand_made import a_sequence, a_snapshot


def test_the_middle_moment_stands_for_a_sequence() -> None:
    sequence = a_sequence()
    assert sample_snapshot(sequence) is sequence.snapshots[1]
    assert sample_snapshot(a_sequence(snapshots=())) is None


def test_one_white_serves_all_frames_of_a_light() -> None:
    dark = a_snapshot()
    assert white_dn([a_sequence(), a_sequence(snapshots=())]) == np.percentile(dark.aps, 99.5)
    assert white_dn([a_sequence(snapshots=())]) == 1.0


def test_boxes_lie_where_the_pixels_do() -> None:
    frame, saliency = Figure().subplots(1, 2)
    draw_aps(frame, a_sequence(), white=1023.0)
    draw_saliency(saliency, a_sequence())
    (box,) = frame.patches
    assert (box.get_xy(), box.get_width(), box.get_height()) == ((7.5, 5.5), 14, 8)
    assert [patch.get_xy() for patch in saliency.patches] == [(7.5, 5.5), (5.5, 5.5)]
    assert tuple(saliency.images[0].get_extent()) == (-0.5, 35.5, 23.5, -0.5)
    assert saliency.get_xlim() == (-0.5, 35.5)
