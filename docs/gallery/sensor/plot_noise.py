"""
What each noise source looks like
=================================

A still card, dark on the left and bright on the right. Nothing moves, so that every event is noise.
Each row has one source of noise, and the last has all of the default sensor.
"""

# %%
# The parameters are those of the default DAVIS346, except for hot and crazy pixels, which it does
# not have: 0.1 % of the pixels are hot, or crazy, here. A hot pixel fires ON at a high rate; a
# crazy pixel fires both at random.

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from flybench import EventSensor, SensorConfig
from scenarios.output.colours import OFF, ON, hex_of

SECONDS = 5
davis = SensorConfig(width=240, height=60)
silent = replace(davis, noise_sigma=0.0, leak_hz=0.0, leak_hz_per_lux=0.0)
SENSORS = {
    "photoreceptor": replace(silent, noise_sigma=davis.noise_sigma),
    "leak, equal in all pixels": replace(
        silent, leak_hz=davis.leak_hz, leak_spread=0.0, leak_tail_fraction=0.0
    ),
    "leak, with its spread": replace(silent, leak_hz=davis.leak_hz),
    "hot pixels": replace(silent, hot_fraction=0.001),
    "crazy pixels": replace(silent, crazy_fraction=0.001),
    "all of the default": davis,
}
card = np.broadcast_to(np.geomspace(0.02, 2_000, 240, dtype=np.float32), (60, 240))

# %%
# Left: the pixels that have fired, in the colour of their last event. Right: the rates of ON and
# OFF events, against the luminance.

figure, panels = plt.subplots(
    len(SENSORS), 2, figsize=(11, 11), layout="constrained", sharex="col", width_ratios=(1.6, 1)
)
for (picture, rates), (name, config) in zip(panels, SENSORS.items(), strict=True):
    sensor = EventSensor(config, seed=1)
    times_us = range(0, SECONDS * 1_000_001, 20_000)
    events = np.concatenate([sensor.step(t_us, card).events for t_us in times_us])
    image = np.full((60, 240, 3), 255, np.uint8)
    image[events["y"], events["x"]] = np.where(events["p"][:, None], ON, OFF)
    picture.imshow(image, interpolation="nearest", aspect="auto")
    picture.set_title(name, loc="left")
    for polarity, colour, label in ((True, ON, "ON"), (False, OFF, "OFF")):
        columns = events["x"][events["p"] == polarity]
        per_bin = np.bincount(columns // 20, minlength=12) / (20 * 60 * SECONDS)
        per_bin = np.where(per_bin > 0, per_bin, np.nan)
        style = "o-" if polarity else "s--"
        rates.loglog(card[0, 10::20], per_bin, style, color=hex_of(colour), label=label, ms=4)
    rates.set_ylim(1e-3, 10)
    rates.set_ylabel("Hz per pixel")
    rates.grid(alpha=0.3)
    picture.set_yticks([])
decades = [0.1, 1, 10, 100, 1_000]
picture.set_xticks(np.searchsorted(card[0], decades), [f"{value:,g}" for value in decades])
picture.set_xlabel("luminance of the card [cd/m²]")
rates.set_xlabel("luminance of the card [cd/m²]")
panels[0, 1].legend()
plt.show()
