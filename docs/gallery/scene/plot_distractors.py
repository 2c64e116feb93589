"""
Every distractor
================

A detector should follow the car. These things move or flicker besides it. For every event, the
ground truth says what caused it.
"""

# %%
# `event_truth` returns the source of each event: the number of a moving object, -1 for the
# background (the camera shook or a lamp flickered), or -2 for noise.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch

from flybench import Crossing, CrossingConfig, Distractors, EventSensor, event_truth

SCENES = {
    "calm street": Distractors(),
    "wind in the trees (Beaufort 7)": Distractors(wind_grade=7),
    "second car, the other way": Distractors(far_vehicle="opposite", far_vehicle_lag_s=0.2),
    "pedestrian in front": Distractors(
        pedestrian="opposite", pedestrian_pavement="near", pedestrian_lag_s=0.3
    ),
    "camera shakes by 0.5°": Distractors(shake_rms_deg=0.5),
    "lamps flicker at 100 Hz (night)": Distractors(flicker_hz=100),
}
TARGET, OTHERS, BACKGROUND, NOISE = "#0072B2", "#D55E00", "#CC79A7", "#999999"


def picture(events, source):
    """Return a white image in which the colour of an event is that of its source."""
    colours = np.array(
        [plt.matplotlib.colors.to_rgb(c) for c in (NOISE, BACKGROUND, TARGET, OTHERS)]
    )
    image = np.ones((260, 346, 3))
    image[events["y"], events["x"]] = colours[np.minimum(source, 1) + 2]
    return image


figure, panels = plt.subplots(3, 2, figsize=(9.5, 10), layout="constrained")
for axes, (name, distractors) in zip(panels.flat, SCENES.items(), strict=True):
    lighting = "night" if distractors.flickers else "day"
    crossing = Crossing(CrossingConfig(lighting=lighting, distractors=distractors, supersample=1))
    passing_us = crossing.duration_us // 2
    sensor = EventSensor(seed=1)
    outputs = [
        sensor.step(sample.t_us, sample.luminance)
        for sample in crossing.samples(range(passing_us - 20_000, passing_us + 1, 2_000))
    ]
    events = np.concatenate([output.events for output in outputs])
    causes = np.concatenate([output.causes for output in outputs])
    truth = event_truth(events, causes, crossing)
    axes.imshow(picture(events, truth.source), interpolation="nearest")
    share = np.mean(truth.source == 0)
    axes.set(xticks=[], yticks=[])
    axes.set_title(f"{name}\n{events.size:,} events, {share:.0%} of the target", fontsize=10)
figure.legend(
    handles=[
        Patch(color=TARGET, label="target"),
        Patch(color=OTHERS, label="another moving object"),
        Patch(color=BACKGROUND, label="background"),
        Patch(color=NOISE, label="noise"),
    ],
    loc="outside lower center",
    ncols=4,
)
figure.suptitle("Events of 20 ms, by their true source")
plt.show()
