"""
The rivals side by side
=======================

Every detector of flybench on the same events: what it answers, from the moment when the car comes
into view, and what an estimate costs.
"""

# %%
# `DETECTORS` is the registry that all commands use. `DetectorFeed` passes events and frames to a
# detector and checks its answers, as the commands do.

import time

import matplotlib.pyplot as plt
import numpy as np

from flybench import Crossing, CrossingConfig, Direction, EventSensor
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.registry import DETECTORS

crossing = Crossing(CrossingConfig(supersample=1))
sensor, outputs, in_view_us = EventSensor(seed=1), [], []
for sample in crossing.samples(range(100_000, 500_000, 2_000)):
    output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
    outputs.append((sample.t_us, output))
    in_view_us += [sample.t_us] if sample.truth.in_view else []
estimates, cost_ms = {}, {}


def run(name, outputs):
    """Return the estimates of a method, and the CPU time of one [ms]."""
    feed = DetectorFeed(name, DETECTORS[name].make(width=346, height=260), width=346, height=260)
    began_s, found = time.thread_time(), []
    for t_us, output in outputs:
        found += feed.feed(output.events, until_us=t_us, frames=output.aps_frames)
    feed.raise_failure()
    return found, 1e3 * (time.thread_time() - began_s) / max(1, len(found))


for name in DETECTORS:
    run(name, outputs[-30:])  # a first run compiles the method
    estimates[name], cost_ms[name] = run(name, outputs)

# %%
# A dot is one estimate. One run of one crossing says little about a method: `flybench study` and
# `flybench envelope` compare them with care. The cost depends on the machine that built this
# page. The shadow of the car comes into view before the car.

figure, axes = plt.subplots(figsize=(11, 6.5), layout="constrained")
styles = {
    "right (the truth)": ("o", "#0072B2", {Direction.RIGHT}),
    "none": (".", "#BBBBBB", {Direction.NONE}),
    "another direction": ("X", "#D55E00", {Direction.LEFT, Direction.UP, Direction.DOWN}),
}
for label, (marker, colour, directions) in styles.items():
    points = [
        (1e-3 * (estimate.t_us - in_view_us[0]), row)
        for row, name in enumerate(DETECTORS)
        for estimate in estimates[name]
        if estimate.direction in directions
    ]
    axes.plot(*np.reshape(points, (-1, 2)).T, marker, color=colour, label=label, markersize=5)
for row, name in enumerate(DETECTORS):
    text = f" {cost_ms[name]:.1f} ms" if estimates[name] else " no estimate yet"
    axes.annotate(text, (1, row), xycoords=("axes fraction", "data"), va="center", fontsize=9)
axes.annotate(" CPU per\n estimate", (1, -0.9), xycoords=("axes fraction", "data"), fontsize=9)
axes.axvline(0, color="grey", linestyle=":")
axes.set_yticks(range(len(DETECTORS)), [entry.label for entry in DETECTORS.values()])
axes.invert_yaxis()
axes.set_xlabel("time after the first pixel of the car is in view [ms]")
axes.legend(loc="upper left", bbox_to_anchor=(0, 1.08), ncols=3, frameon=False)
plt.show()
