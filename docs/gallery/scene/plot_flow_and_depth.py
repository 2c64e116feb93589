"""
Flow and depth
==============

The exact depth and image velocity of every pixel, at any time. They follow from the geometry of the
scene, without rendering.
"""

# %%
# A van, a second car that drives the other way, a pedestrian, and trees in the wind.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm, hsv_to_rgb

from flybench import Crossing, CrossingConfig, Distractors
from sim import DenseTruth
from sim.preview import Preview

crossing = Crossing(
    CrossingConfig(
        vehicle="van",
        distractors=Distractors(
            wind_grade=6, far_vehicle="opposite", far_vehicle_lag_s=0.35, pedestrian="same"
        ),
    )
)
passing_us = crossing.duration_us // 2
truth = DenseTruth(crossing.scene, crossing.intrinsics)
depth_m = truth.depth_m(crossing.seconds(passing_us))
flow_px_s = truth.flow_px_s(crossing.seconds(passing_us))
with Preview(crossing) as preview:
    colours = preview.render(passing_us)


def flow_colours(flow, fastest):
    """Return an image: the hue is the direction of motion, the strength its speed (log scale)."""
    hue = np.arctan2(flow[..., 1], flow[..., 0]) / (2 * np.pi) % 1
    speed = np.hypot(flow[..., 0], flow[..., 1])
    strength = np.clip(np.log1p(speed) / np.log1p(fastest), 0, 1)
    return hsv_to_rgb(np.stack([hue, strength, np.ones_like(hue)], axis=-1))


# %%
# An arrow shows the motion of 25 ms. Red moves to the right, cyan to the left; wheels turn and
# leaves sway. The depth of the sky is infinite, and shown in white.

figure, panels = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
panels[0].imshow(colours)
panels[0].set_title("the street")
shown = panels[1].imshow(
    np.where(np.isfinite(depth_m), depth_m, np.nan), "viridis_r", norm=LogNorm()
)
bar = figure.colorbar(
    shown, ax=panels[1], shrink=0.8, label="depth [m]", ticks=[3, 5, 10, 20], format="%g"
)
bar.minorticks_off()
panels[1].set_title("depth")
speed = np.hypot(flow_px_s[..., 0], flow_px_s[..., 1])
panels[2].imshow(flow_colours(flow_px_s, speed.max()))
y, x = np.mgrid[8:260:12, 8:346:12]
moving = speed[y, x] > 1
u, v = (0.025 * flow_px_s[y, x, k][moving] for k in (0, 1))
panels[2].quiver(x[moving], y[moving], u, v, angles="xy", scale_units="xy", scale=1, width=0.004)
panels[2].set_title(f"image velocity, up to {speed.max():.0f} px/s")
for axes in panels:
    axes.set(xticks=[], yticks=[])
plt.show()
