"""
Time surfaces
=============

A time surface tells how recent the events of a place are. The same events give three surfaces: the
usual one of single pixels, that of the paper, and that of the preset ``robust``.
"""

# %%
# The usual surface holds e^(−age / τ) of the last event of each pixel. The paper's sums over all
# earlier events of a pixel, and averages over cells of 3 × 3 pixels. In ``robust``, every event
# brings the pixel nearer to 1, and the mean over the field is subtracted later.

import matplotlib.pyplot as plt
import numpy as np

from flybench import Crossing, CrossingConfig, EventSensor, FlyConfig, FlyDetector

TAU_US = 30_000  # time constant of the paper

crossing = Crossing(CrossingConfig(vehicle="motorcycle", supersample=1))
passing_us = crossing.duration_us // 2
flies = {name: FlyDetector(FlyConfig.preset(name)) for name in ("paper", "robust")}
sensor, parts = EventSensor(seed=1), []
for sample in crossing.samples(range(passing_us - 200_000, passing_us, 2_000)):
    output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
    parts.append(output.events)
    for fly in flies.values():
        fly.push(output.events)
events = np.concatenate(parts)


def of_pixels(events):
    """Return e^(−age / τ) of the last event of every pixel."""
    last_us = np.full((260, 346), -np.inf)
    last_us[events["y"], events["x"]] = events["t"]  # later events replace earlier ones
    return np.exp((last_us - events["t"][-1]) / TAU_US)


# %%
# All panels show the same moment. The motorcycle drives to the right, and its surfaces fade
# behind it. An estimate of the fly uses the mean of the surfaces over a window, not their last
# state.

figure, panels = plt.subplots(2, 3, figsize=(11, 5.6), layout="constrained")
for row, polarity in zip(panels, (True, False), strict=True):
    surfaces = {"single pixels, τ = 30 ms": of_pixels(events[events["p"] == polarity])}
    for name, fly in flies.items():
        surfaces[f"cells, {name}"] = fly.maps.on if polarity else fly.maps.off
    for axes, (name, surface) in zip(row, surfaces.items(), strict=True):
        shown = axes.imshow(surface, cmap="magma", vmin=0)
        axes.set_title(f"{'ON' if polarity else 'OFF'}, {name}", fontsize=10)
        axes.set(xticks=[], yticks=[])
        figure.colorbar(shown, ax=axes, shrink=0.7)
plt.show()
