import numpy as np
from matplotlib.figure import Figure

from scenarios.study.figures.snapshot_panels import (
    draw_aps,
    draw_saliency,
    middle_snapshot,
    white_level_dn,
)
from tests.scenarios.study.synthetic_results import make_sequence, make_snapshot


def test_the_middle_snapshot_represents_a_sequence() -> None:
    sequence = make_sequence()
    assert middle_snapshot(sequence) is sequence.snapshots[1]
    assert middle_snapshot(make_sequence(snapshots=())) is None


def test_all_frames_have_one_white_level() -> None:
    dark = make_snapshot()
    assert white_level_dn([make_sequence(), make_sequence(snapshots=())]) == np.percentile(
        dark.aps, 99.5
    )
    assert white_level_dn([make_sequence(snapshots=())]) == 1.0


def test_boxes_are_aligned_with_the_pixels() -> None:
    frame, saliency = Figure().subplots(1, 2)
    draw_aps(frame, make_sequence(), white_dn=1023.0)
    draw_saliency(saliency, make_sequence())
    (box,) = frame.patches
    assert (box.get_xy(), box.get_width(), box.get_height()) == ((7.5, 5.5), 14, 8)
    assert [patch.get_xy() for patch in saliency.patches] == [(7.5, 5.5), (5.5, 5.5)]
    assert tuple(saliency.images[0].get_extent()) == (-0.5, 35.5, 23.5, -0.5)
    assert saliency.get_xlim() == (-0.5, 35.5)
