"""
A robot arm
===========

An event camera in a MuJoCo model, while its physics runs. The model is that of
``examples/robot_arm``: four motors swing the arm to the right.
"""

# %%
# `EventCamera.step` is called after each step of the physics. It renders only when something has
# moved far enough in the image: here by 2 pixels. The default, half a pixel, takes longer and
# gives better times of events.

from pathlib import Path

import matplotlib.pyplot as plt
import mujoco
import numpy as np

from flybench import EventCamera, FlyConfig, FlyDetector, open_model
from scenarios.output.colours import OFF, ON

model = open_model(Path("../../../examples/robot_arm/arm.xml"))
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, 0)


def step():
    """Move the targets of the motors, and advance the physics by half a millisecond."""
    data.ctrl[:] = -np.array([0.0, 0.75, 0.45, 0.3]) * np.cos(np.pi * min(2 * data.time, 1))
    mujoco.mj_step(model, data)


while data.time < 0.2:  # the arm gathers speed while nobody looks
    step()
fly, events, estimates = FlyDetector(FlyConfig.preset("robust")), [], []
with EventCamera(model, "eye", seed=1, step_px=2.0, supersample=1) as camera:
    while data.time < 0.3:
        step()
        output = camera.step(data)
        events.append(output.events)
        estimates += fly.push(output.events)
    luminance = camera.luminance
events = np.concatenate(events)
print(f"{camera.samples} renderings, {events.size:,} events")

# %%
figure, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
shown = panels[0].imshow(luminance, cmap="cividis", norm="log")
figure.colorbar(shown, ax=panels[0], label="luminance [cd/m²]", shrink=0.8)
panels[0].set_title("what the camera sees")
image = np.full((260, 346, 3), 255, np.uint8)
last = events[events["t"] > events["t"][-1] - 20_000]
image[last["y"], last["x"]] = np.where(last["p"][:, None], ON, OFF)
panels[1].imshow(image, interpolation="nearest")
x0, y0, x1, y1 = estimates[-1].roi_px
panels[1].plot([x0, x1, x1, x0, x0], [y0, y0, y1, y1, y0], color="#E69F00", lw=2.5)
panels[1].set_title(f"events of 20 ms, attended region\nthe fly says: {estimates[-1].direction}")
for axes in panels:
    axes.set(xticks=[], yticks=[])
plt.show()
