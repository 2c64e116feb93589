"""
Every vehicle
=============

A sedan, a van and a motorcycle at the same place, as a person, a sensor and the ground truth see
them.
"""

# %%
# `Preview` renders colour images for people. The sensor sees luminance, in cd/m².

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

from flybench import Crossing, CrossingConfig, EventSensor, VehicleKind
from scenarios.output.colours import OFF, ON
from sim.preview import Preview


def picture(events):
    """Return a white image with ON events in blue and OFF events in vermilion."""
    image = np.full((260, 346, 3), 255, np.uint8)
    image[events["y"], events["x"]] = np.where(events["p"][:, None], ON, OFF)
    return image


figure, panels = plt.subplots(3, 3, figsize=(11, 8), layout="constrained")
for row, vehicle in zip(panels, VehicleKind, strict=True):
    crossing = Crossing(CrossingConfig(vehicle=vehicle, supersample=2))
    passing_us = crossing.duration_us // 2
    with Preview(crossing) as preview:
        row[0].imshow(preview.render(passing_us))
    sensor = EventSensor(seed=1)
    outputs = [
        (sensor.step(sample.t_us, sample.luminance).events, sample.truth)
        for sample in crossing.samples(range(passing_us - 20_000, passing_us + 1, 2_000))
    ]
    events, truth = np.concatenate([events for events, _ in outputs]), outputs[-1][1]
    row[1].imshow(picture(events), interpolation="nearest")
    row[2].imshow(truth.mask, cmap="gray_r", vmax=3)
    x0, y0, x1, y1 = truth.bounding_box_px
    row[2].add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, color="black"))
    row[0].set_title(vehicle)
    row[1].set_title(f"{events.size:,} events in 20 ms")
    row[2].set_title(f"true mask and box, {x1 - x0} × {y1 - y0} px")
for axes in panels.flat:
    axes.set(xticks=[], yticks=[])
figure.suptitle("Vehicles at 40 km/h, by day. ON events are blue, OFF events vermilion")
plt.show()
