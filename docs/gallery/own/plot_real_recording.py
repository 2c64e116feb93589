"""
A real recording
================

Read a recording of any event camera and find the direction of motion. Recordings of other people
are not part of flybench, so this page shows one only if it finds it.
"""

# %%
# Set ``RECORDING`` to a file of your own: flybench recognises AEDAT, Prophesee RAW, HDF5, ROS
# bags and others by their contents. Without a file, this page emulates a bar that moves to the
# right, writes it as AEDAT 4, and reads it back.
#
# A public one is that of a Newton's cradle: ``flybench validate --recording cradle`` downloads it
# once and scores the detectors on it.

import os
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from flybench import Davis346, FlyConfig, FlyDetector, open_events, write_events
from scenarios.output.colours import OFF, ON

RECORDING = Path(os.environ.get("FLYBENCH_RECORDINGS", ".")) / "cradle.aedat4"


def emulated_bar(path):
    """Write a recording of a bright bar that moves at 250 px/s in front of a grey wall."""
    sensor, parts, x = Davis346(seed=1), [], np.arange(346)
    for t_us in range(0, 500_000, 1_000):
        edge_px = 100 + 250e-6 * t_us
        profile = 100 + 300 * np.clip(edge_px - x, 0, 1) * np.clip(x - edge_px + 40, 0, 1)
        luminance = np.full((260, 346), 100, np.float32)
        luminance[80:180] = profile
        parts.append(sensor.step(t_us, luminance).events)
    write_events(path, parts, width=346, height=260)


if RECORDING.is_file():
    path, kind = RECORDING, "a real DAVIS346, Newton's cradle (github.com/KugaMaxx/cuke-emlb, MIT)"
else:
    path, kind = Path(tempfile.mkdtemp()) / "bar.aedat4", "no real recording here: an emulated bar"
    emulated_bar(path)

# %%
# The file is read in chunks, in constant memory.

with open_events(path) as file:
    size = file.width, file.height
    fly = FlyDetector(FlyConfig.preset("robust"), width=file.width, height=file.height)
    estimates, shown, strongest = [], None, -1.0
    for chunk in file:
        for part in np.array_split(chunk.events, max(1, chunk.events.size // 5_000)):
            for estimate in fly.push(part):
                estimates.append(estimate)
                if estimate.strength > strongest and estimate.roi_px is not None:
                    strongest, shown = estimate.strength, (estimate, part)
    print(f"{file.format}, {size[0]}×{size[1]} px, {file.statistics.events:,} events")

# %%
figure, (picture, response) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
estimate, events = shown
image = np.full((size[1], size[0], 3), 255, np.uint8)
image[events["y"], events["x"]] = np.where(events["p"][:, None], ON, OFF)
picture.imshow(image, interpolation="nearest")
x0, y0, x1, y1 = estimate.roi_px
picture.plot([x0, x1, x1, x0, x0], [y0, y0, y1, y1, y0], color="#E69F00", lw=2.5)
picture.set(xticks=[], yticks=[])
picture.set_title(
    f"{events.size:,} events up to {1e-6 * estimate.t_us:.2f} s: {estimate.direction}"
)
times_s = [1e-6 * e.t_us for e in estimates]
response.plot(times_s, [e.hs for e in estimates], color="#0072B2", label="HS: right is positive")
response.plot(times_s, [e.vs for e in estimates], "--", color="#D55E00", label="VS: down")
response.set(xlabel="time [s]", ylabel="response", ylim=(-1.05, 1.05))
response.legend(loc="lower left")
response.grid(alpha=0.3)
figure.suptitle(kind)
plt.show()
