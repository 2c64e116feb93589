"""
S-curve of the contrast threshold
=================================

How large must a change of luminance be, so that a pixel fires? The experiment of the laboratory, on
the emulated sensor: hundreds of pixels see one step of each size, and we count those that respond.
"""

# %%
# The thresholds are set to 0.28 (ON) and 0.35 (OFF) ln units, with a spread of 0.024 over the
# pixels. In bright light the experiment finds them. In dim light, noise makes pixels fire earlier
# and widens the curve; in very dim light the dark current also hides a part of each step.

import matplotlib.pyplot as plt
from scipy.special import ndtr

from emulator.characterisation.experiments.s_curve import measure_s_curve
from flybench import SensorConfig

sensor = SensorConfig()
figure, panels = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained", sharey=True)
for axes, on in zip(panels, (True, False), strict=True):
    for lux, colour, marker in (
        (1_000, "#0072B2", "o"),
        (1, "#E69F00", "s"),
        (0.05, "#000000", "^"),
    ):
        curve = measure_s_curve(sensor, chip_lux=lux, on=on, seed=1)
        axes.plot(
            curve.contrast, 100 * curve.probability, marker, color=colour, markersize=4, alpha=0.6
        )
        share = ndtr((curve.contrast - curve.threshold) / curve.mismatch)
        fitted = curve.guess + (1 - curve.guess - curve.lapse) * share
        label = f"{lux:g} lux: θ = {curve.threshold:.2f}, σ = {curve.mismatch:.3f}"
        axes.plot(curve.contrast, 100 * fitted, color=colour, label=label)
    axes.axvline(
        sensor.theta_on if on else sensor.theta_off,
        color="grey",
        linestyle=":",
        label="threshold that is set",
    )
    axes.set_title("steps up, ON events" if on else "steps down, OFF events")
    axes.set_xlabel("size of the step [ln units of luminance]")
    axes.legend(title="illuminance on the chip, and fit", fontsize=8, loc="lower right")
    axes.grid(alpha=0.3)
panels[0].set_ylabel("pixels that respond [%]")
plt.show()
