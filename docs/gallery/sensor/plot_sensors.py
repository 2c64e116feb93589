"""
Every sensor on the same scene
==============================

The presets of flybench in front of the same street, each behind the same lens (6 mm, f/1.4). A
larger chip sees a wider part of the street, and smaller pixels see it finer.
"""

# %%
# `Intrinsics` is the lens and the size of the sensor. Where no source gives the parameters of the
# pixels of a chip, its preset has those of the DAVIS346: see ``emulator/presets.py``.

from functools import cache
from typing import get_args

import matplotlib.pyplot as plt
import numpy as np

from emulator.presets import PresetName
from flybench import Crossing, CrossingConfig, EventSensor, Intrinsics, preset
from scenarios.output.colours import OFF, ON


@cache
def samples(lens):
    """Return the luminance of 20 ms through a lens; presets with the same lens share it."""
    crossing = Crossing(CrossingConfig(supersample=1), lens)
    passing_us = crossing.duration_us // 2
    return list(crossing.samples(range(passing_us - 20_000, passing_us + 1, 4_000)))


def watch(name):
    """Return the events of 20 ms on the sensor of this name, as an image."""
    config = preset(name)
    lens = Intrinsics(config.width, config.height, config.focal_length_px)
    sensor = EventSensor(config, seed=1)
    steps = [sensor.step(sample.t_us, sample.luminance) for sample in samples(lens)]
    events = np.concatenate([step.events for step in steps])
    image = np.full((config.height, config.width, 3), 255, np.uint8)
    image[events["y"], events["x"]] = np.where(events["p"][:, None], ON, OFF)
    return image, events.size


# %%
# Each panel has the angle of view that the sensor has.

names = get_args(PresetName)
figure, panels = plt.subplots(4, 3, figsize=(11, 11), layout="constrained")
for axes, name in zip(panels.flat, names, strict=False):
    image, number = watch(name)
    axes.imshow(image, interpolation="nearest")
    height, width, _ = image.shape
    axes.set_title(f"{name}, {width}×{height} px\n{number:,} events in 20 ms", fontsize=10)
for axes in panels.flat:
    axes.set_axis_off()
figure.suptitle("By day. ON events are blue, OFF events vermilion")
plt.show()
