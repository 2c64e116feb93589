"""Further detectors of a run, which get the same events and frames: the option `--also`."""

from __future__ import annotations

from collections.abc import Sequence

from detector.estimate import MotionEstimate
from scenarios.errors import ScenarioError
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import Step
from scenarios.pipeline.user_detectors import find_method


class ExtraDetector:
    """A further detector that gets the events and frames of a run.

    Attributes:
        feed: the detector.
        estimates: all estimates so far.
    """

    def __init__(self, method: str, config: RunConfig) -> None:
        """Create a fresh detector for the sensor of a run.

        Raises:
            MethodError: the method does not exist, or does not follow the protocol.
        """
        size = {"width": config.sensor.width, "height": config.sensor.height}
        self.feed = DetectorFeed(method, find_method(method).make(**size), **size)
        self.estimates: list[MotionEstimate] = []

    def process(self, step: Step) -> list[MotionEstimate]:
        """Pass the sensor's output to the detector, and return the new estimates."""
        new = self.feed.feed(
            step.output.events, until_us=step.sample.t_us + 1, frames=step.output.aps_frames
        )
        self.estimates += new
        return new


def make_extra_detectors(config: RunConfig, also: Sequence[str]) -> list[ExtraDetector]:
    """Return fresh detectors for the methods of `--also`.

    Raises:
        ScenarioError: a method is named twice.
        MethodError: a method does not exist, or does not follow the protocol.
    """
    names = [config.method, *also]
    for n, name in enumerate(names):
        if name in names[:n]:
            raise ScenarioError(
                f"--also names {name}, which runs already. Allowed is each method once. Leave it "
                "out."
            )
    return [ExtraDetector(method, config) for method in also]
