"""
Events of one pixel
===================

A pixel of an emulated DAVIS346 sees a lamp whose luminance varies as a sine. It sends an ON event
when the logarithm of the luminance rises by the contrast threshold, and an OFF event when it falls.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import flybench

sensor = flybench.EventSensor(replace(flybench.preset("davis346"), width=1, height=1), seed=0)
t_us = np.arange(0, 400_000, 1000)
luminance = 100 * (1 + 0.8 * np.sin(2 * np.pi * 5e-6 * t_us))  # [cd/m²]
events = np.concatenate(
    [
        sensor.step(t, np.full((1, 1), level)).events
        for t, level in zip(t_us, luminance, strict=True)
    ]
)

# %%
# The events are few at the extremes, where the luminance hardly changes.

figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
axes.plot(t_us / 1000, luminance, color="0.5")
for polarity, colour, name in ((True, "#0072b2", "ON"), (False, "#d55e00", "OFF")):
    times = events["t"][events["p"] == polarity]
    axes.plot(times / 1000, np.interp(times, t_us, luminance), "o", color=colour, label=name)
axes.set(xlabel="time [ms]", ylabel="luminance [cd/m²]")
axes.legend()
plt.show()
