"""
Attention follows the target
============================

The fly attends to the most salient place and follows it. The region around this view centre is all
that counts for the direction.
"""

# %%
# A crossing at 60 km/h by day. `roi_px` of an estimate is the box around the attended region.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

from flybench import Crossing, CrossingConfig, EventSensor, FlyDetector
from scenarios.output.colours import OFF, ON

crossing = Crossing(CrossingConfig(omega_rad_s=2.42, lead_s=0.1, supersample=1))
times_us = range(0, crossing.duration_us, 2_000)
sensor, fly, events = EventSensor(seed=1), FlyDetector(), []
estimates, centroids = [], []
for sample in crossing.samples(times_us):
    output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
    events.append(output.events)
    estimates += fly.push(output.events)
    centroid = sample.truth.centroid_px
    centroids.append((np.nan, np.nan) if centroid is None else centroid)
events = np.concatenate(events)

# %%
# Above: the events of 20 ms and the region (orange) at four moments. Below: where the fly looks,
# and where the centroid of the visible part of the car is. The fly holds on to one wheel; when
# that leaves the image, it turns to the other.

figure = plt.figure(figsize=(11, 6), layout="constrained")
above, below = figure.subfigures(2, 1, height_ratios=(1, 1.2))
shown = [estimates[round(share * len(estimates))] for share in (0.3, 0.45, 0.6, 0.75)]
for axes, estimate in zip(above.subplots(1, 4), shown, strict=True):
    recent = events[(events["t"] < estimate.t_us) & (events["t"] >= estimate.t_us - 20_000)]
    image = np.full((260, 346, 3), 255, np.uint8)
    image[recent["y"], recent["x"]] = np.where(recent["p"][:, None], ON, OFF)
    axes.imshow(image, interpolation="nearest")
    if estimate.roi_px is not None:
        x0, y0, x1, y1 = estimate.roi_px
        axes.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, color="#E69F00", lw=2.5))
    axes.plot(*estimate.view_centre_px, "k+", markersize=12, mew=2)
    axes.set(xticks=[], yticks=[], title=f"{estimate.t_us / 1000:.0f} ms: {estimate.direction}")
axes = below.subplots()
axes.plot(1e-3 * np.array(times_us), [x for x, _ in centroids], color="black", label="car (truth)")
attending = [e for e in estimates if e.roi_px is not None]
times_ms = [1e-3 * e.t_us for e in attending]
left, right = ([e.roi_px[k] for e in attending] for k in (0, 2))
axes.vlines(times_ms, left, right, color="#E69F00", alpha=0.5, label="attended region")
axes.plot(times_ms, [e.view_centre_px[0] for e in attending], "k+", label="view centre")
axes.set(xlabel="time [ms]", ylabel="x [px]", ylim=(0, 346))
axes.legend(loc="upper left")
plt.show()
