"""Summary of a run, for `summary.json` and for the table that the command prints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from emulator import SensorOutput
from flybench.events import Cause
from scenarios.output.atomic_folder import GENERATOR
from scenarios.output.versions import versions
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.registry import is_fly
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.scoring import TargetTrack, score_estimates
from sim import Crossing
from sim.render.vulkan import vulkan_devices


@dataclass
class EventTally:
    """Counts of events by polarity and cause."""

    on: int = 0
    off: int = 0
    by_cause: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(len(Cause), np.int64))

    def add(self, output: SensorOutput) -> None:
        """Add the events of one sensor step."""
        on = int(np.count_nonzero(output.events["p"]))
        self.on += on
        self.off += output.events.size - on
        self.by_cause += np.bincount(output.causes, minlength=len(Cause))

    def summary(self) -> dict[str, Any]:
        """Return the counts by polarity and by cause."""
        causes = {cause.name.lower(): int(self.by_cause[cause]) for cause in Cause}
        return {"count": self.on + self.off, "on": self.on, "off": self.off, "by_cause": causes}


def summarise(
    config: RunConfig,
    crossing: Crossing,
    tally: EventTally,
    scores: dict[str, Any],
    track: TargetTrack,
) -> dict[str, Any]:
    """Return everything about a run that is not an array, ready for JSON, except its wall time.

    The detector's scores are under "detector", and also under "fly" if the detector is the fly.

    Args:
        config: configuration of the run.
        crossing: scene of the run.
        tally: counts of its events.
        scores: scores of the detector; see `method_scores`.
        track: ground truth of the target's position.
    """
    return {
        "generator": GENERATOR,
        "parameters": asdict(config) | {"crossing": config.crossing.resolved()},
        "seed": config.seed,
        "versions": versions(),
        "devices": [f"{device.name}: {device.driver}" for device in vulkan_devices()],
        "truth": truth_summary(config, crossing, track.in_view_us),
        "events": tally.summary(),
        "detector": scores,
    } | ({"fly": scores} if is_fly(config.method) else {})


def method_scores(
    feed: DetectorFeed, estimates: Sequence[MotionEstimate], config: RunConfig, track: TargetTrack
) -> dict[str, Any]:
    """Return the name of a detector and its scores; the reason instead of scores if it failed.

    Args:
        feed: the detector.
        estimates: all its estimates.
        config: configuration of the run.
        track: ground truth of the target's position.
    """
    if feed.failure is not None:
        return {"method": feed.method, "failed": str(feed.failure), "estimates": len(estimates)}
    direction = config.crossing.direction
    scores = score_estimates(estimates, direction, track.in_view_us, track)
    return {"method": feed.method} | scores


def truth_summary(
    config: RunConfig, crossing: Crossing, in_view_us: tuple[int, int]
) -> dict[str, Any]:
    """Return the target's motion, and the first and last time at which it is in view."""
    c = config.crossing
    speed_m_s = crossing.trajectory.speed_m_s(0.0)
    return {
        "direction": c.direction.value,
        "omega_rad_s": c.omega_rad_s,
        "speed_km_h": speed_m_s * 3.6,
        "image_speed_px_s": crossing.intrinsics.focal_px * speed_m_s / c.distance,
        "enters_view_us": in_view_us[0],
        "leaves_view_us": in_view_us[1],
        "duration_us": crossing.duration_us,
    }
