"""
A video of your own
===================

Turn a video into events and APS frames. Set ``VIDEO`` to a file of yours. Without one, this page
makes a small video of a turning wheel.
"""

# %%
# The video has 120 frames per second. The rim moves by 3.5 pixels from one frame to the next, so
# that images are interpolated by optical flow.

import tempfile
from pathlib import Path

import cv2
import matplotlib.pyplot as plt
import numpy as np

from flybench import EventSensor, preset
from scenarios.emulate.luminance_samples import MotionStatistics, luminance_samples
from scenarios.emulate.pictures import open_pictures
from scenarios.output.colours import OFF, ON

VIDEO = Path("mine.mp4")


def turning_wheel(path):
    """Write a video of a wheel with five spokes that turns clockwise by 2° per frame."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 120, (346, 260))
    for k in range(24):
        image = np.full((260, 346, 3), 90, np.uint8)
        cv2.circle(image, (173, 130), 105, (200, 200, 200), 12, cv2.LINE_AA)
        for spoke in range(5):
            angle = np.radians(2 * k + 72 * spoke)
            end = 173 + 100 * np.cos(angle), 130 + 100 * np.sin(angle)
            cv2.line(image, (173, 130), tuple(map(round, end)), (200, 200, 200), 12, cv2.LINE_AA)
        writer.write(image)
    writer.release()


path = VIDEO
if not path.is_file():
    path = Path(tempfile.mkdtemp()) / "wheel.mp4"
    turning_wheel(path)

# %%
# On the command line, this is ``flybench emulate mine.mp4 --interpolate --out mine.aedat4``.

config = preset("davis346")
sensor, motion = EventSensor(config, seed=1), MotionStatistics()
events, frames, images = [], [], []
for sample in luminance_samples(
    open_pictures(path),
    size=(config.width, config.height),
    white_cd_m2=200.0,
    transfer="srgb",
    interpolate=True,
    motion=motion,
):
    output = sensor.step(sample.t_us, sample.luminance)
    events.append(output.events)
    frames += output.aps_frames
    images.append(sample.luminance)
events = np.concatenate(events)
print(f"{motion.max_px:.1f} px between frames, {len(images)} images for the sensor")

# %%
figure, panels = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
shown = panels[0].imshow(images[-1], cmap="gray")
figure.colorbar(shown, ax=panels[0], shrink=0.8, label="luminance [cd/m²]")
panels[0].set_title("the last image of the video")
image = np.full((260, 346, 3), 255, np.uint8)
last = events[events["t"] > events["t"][-1] - 20_000]
image[last["y"], last["x"]] = np.where(last["p"][:, None], ON, OFF)
panels[1].imshow(image, interpolation="nearest")
panels[1].set_title(f"{last.size:,} events of 20 ms")
panels[2].imshow(frames[-1].image, cmap="gray")
panels[2].set_title(f"APS frame, exposed for {frames[-1].exposure_us / 1000:.1f} ms")
for axes in panels:
    axes.set(xticks=[], yticks=[])
plt.show()
