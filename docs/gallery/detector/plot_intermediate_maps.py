"""
From events to a direction: the maps of the paper
=================================================

Fig. 2 of the paper shows how the fly computes a direction. These are the same stages, with the maps
of one estimate: time surfaces, local motion, saliency and attended region, and the response.
"""

# %%
# `FlyDetector.maps` holds the maps behind the last estimate. One value stands for a cell of 3 × 3
# pixels.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import PowerNorm

from flybench import Crossing, CrossingConfig, EventSensor, FlyDetector
from scenarios.output.colours import OFF, ON

crossing = Crossing(CrossingConfig(supersample=1))
passing_us = crossing.duration_us // 2
sensor, fly, events, estimates = EventSensor(seed=1), FlyDetector(), [], []
for sample in crossing.samples(range(passing_us - 250_000, passing_us, 2_000)):
    output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
    events.append(output.events)
    estimates += fly.push(output.events)
maps, cell = fly.maps, fly.maps.cell_px
print(f"{estimates[-1].direction}, with a strength of {estimates[-1].strength:.2f}")

# %%
# The car drives to the right, so that the map of motion to the right has the largest values
# (their colours follow the square root). The response is summed over the attended region only:
# the outline around the cross, the view centre.

figure, panels = plt.subplots(3, 3, figsize=(11, 8), layout="constrained")
(event_panel, on, off), (right, left, up), (down, attention, response) = panels
image = np.full((260, 346, 3), 255, np.uint8)
last = np.concatenate(events[-5:])
image[last["y"], last["x"]] = np.where(last["p"][:, None], ON, OFF)
event_panel.imshow(image, interpolation="nearest")
event_panel.set_title("events of 10 ms (eq. 1)")
strongest = max(maps.on.max(), maps.off.max())
for axes, surface, name in ((on, maps.on, "ON"), (off, maps.off, "OFF")):
    shown = axes.imshow(surface, cmap="magma", vmin=0, vmax=strongest)
    axes.set_title(f"time surface, {name} (eq. 2 to 8)")
figure.colorbar(shown, ax=[on, off], shrink=0.7, label="averaged surface")
for axes, plane, name in zip(
    (right, left, up, down), maps.motion, ("right", "left", "up", "down"), strict=True
):
    shown = axes.imshow(plane, cmap="magma", norm=PowerNorm(0.5, 0, maps.motion.max()))
    axes.set_title(f"T4 + T5, {name} (eq. 9)")
figure.colorbar(shown, ax=[left, up], shrink=0.7, label="correlation")
attention.imshow(maps.saliency, cmap="gray_r")
attention.contour(maps.attended, levels=[0.5], colors=["#D55E00"])
x, y = estimates[-1].view_centre_px
attention.plot(x / cell - 0.5, y / cell - 0.5, "+", color="#0072B2", markersize=14, mew=3)
attention.set_title("saliency and attended region\n(eq. 10 to 16)")
times_ms = [1e-3 * (estimate.t_us - estimates[-1].t_us) for estimate in estimates]
response.plot(times_ms, [e.hs for e in estimates], color="#0072B2", label="HS (right is positive)")
response.plot(times_ms, [e.vs for e in estimates], "--", color="#D55E00", label="VS (down)")
response.set(xlim=(-200, 0), xlabel="time before this estimate [ms]")
response.set_title("response (eq. 17 to 19)")
response.legend(loc="center right", fontsize=8)
for axes in panels.flat[:-1]:
    axes.set(xticks=[], yticks=[])
plt.show()
