"""The built-in detectors."""

from dataclasses import replace

import pytest

from detector.contrast_maximisation.detector import ContrastMaximisation
from detector.contrast_maximisation.edge_informed import EdgeInformedContrast
from detector.estimate import FrameDetector
from detector.fly.config import FlyConfig
from detector.fly.detector import FlyDetector
from detector.fly.model_variants import Attention
from detector.frame_fly.detector import FrameFly
from detector.plane_fit.detector import PlaneFit
from detector.space_time_filters.detector import SpaceTimeFilters
from detector.spiking_delays.detector import SpikingDelays
from detector.time_difference.detector import TimeDifference
from scenarios.pipeline.registry import DETECTORS, gives_velocity


@pytest.mark.parametrize(
    ("name", "preset"), [("fly", "paper"), ("wide", "wide"), ("robust", "robust")]
)
def test_the_fly_has_a_name_for_each_preset(name: str, preset: str) -> None:
    fly = DETECTORS[name].make(width=346, height=260)
    assert isinstance(fly, FlyDetector)
    assert fly.config == FlyConfig.preset(preset)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("frame-fly", FrameFly),
        ("frame-fly-coarse", FrameFly),
        ("contrast-maximisation", ContrastMaximisation),
        ("edge-informed-contrast", EdgeInformedContrast),
        ("plane-fit", PlaneFit),
        ("space-time-filters", SpaceTimeFilters),
        ("spiking-delays", SpikingDelays),
        ("time-difference", TimeDifference),
    ],
)
def test_every_baseline_has_a_name(name: str, kind: type) -> None:
    assert isinstance(DETECTORS[name].make(width=64, height=48), kind)


def test_every_entry_describes_its_detector() -> None:
    for entry in DETECTORS.values():
        detector = entry.make(width=346, height=260)
        assert detector.config == entry.config  # type: ignore[attr-defined]
        assert isinstance(detector, FrameDetector) == entry.looks_at_frames


def test_the_entries_without_attention_differ_in_nothing_else() -> None:
    pairs = {
        entry.name: DETECTORS[entry.without_attention]
        for entry in DETECTORS.values()
        if entry.without_attention is not None
    }
    assert set(pairs) == {"fly", "wide", "robust"}
    for name, other in pairs.items():
        expected = replace(DETECTORS[name].config, attention=Attention.EVERYWHERE)
        assert other.config == expected
        assert not other.in_study


def test_a_filter_does_not_change_what_a_response_means() -> None:
    methods = ("plane-fit", "stcf+plane-fit", "fly", "stcf+fly", "my.module:Class")
    assert [gives_velocity(method) for method in methods] == [True, True, False, False, False]
