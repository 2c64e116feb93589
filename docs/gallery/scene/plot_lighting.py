"""
Day, dusk and night
===================

The same car crosses the same street three times. The light falls by a factor of 3,000. The events
come later and are blurred, noise appears, and the frames need 200 ms.
"""

# %%
# Each crossing is rendered for 0.3 s, up to the moment when the car passes the camera. The
# samples are 2 ms apart, which is one pixel of motion here. `flybench run` uses half a pixel.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

from flybench import Crossing, CrossingConfig, EventSensor, Lighting
from scenarios.output.colours import OFF, ON


def watch(lighting):
    """Return the last luminance, the events of the last 20 ms, and the last APS frame."""
    crossing = Crossing(CrossingConfig(lighting=lighting, supersample=1))
    passing_us = crossing.duration_us // 2
    sensor, events, frame = EventSensor(seed=1), [], None
    for sample in crossing.samples(range(passing_us - 300_000, passing_us, 2_000)):
        output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
        events.append(output.events)
        frame = output.aps_frames[-1] if output.aps_frames else frame
    return sample.luminance, np.concatenate(events[-10:]), frame


def picture(events):
    """Return a white image with ON events in blue and OFF events in vermilion."""
    image = np.full((260, 346, 3), 255, np.uint8)
    image[events["y"], events["x"]] = np.where(events["p"][:, None], ON, OFF)
    return image


# %%
# The colour scale of the luminance is the same in all three rows.

figure, panels = plt.subplots(3, 3, figsize=(11, 8), layout="constrained")
for row, lighting in zip(panels, Lighting, strict=True):
    luminance, events, frame = watch(lighting)
    shown = row[0].imshow(luminance, cmap="cividis", norm=LogNorm(0.02, 20_000))
    row[0].set_title(f"{lighting}: {float(f'{np.median(luminance):.2g}'):,g} cd/m² (median)")
    row[1].imshow(picture(events), interpolation="nearest")
    row[1].set_title(f"{events.size:,} events in 20 ms")
    row[2].imshow(frame.image, cmap="gray", vmin=0)
    row[2].set_title(f"APS frame, exposed for {frame.exposure_us / 1000:.1f} ms")
for axes in panels.flat:
    axes.set(xticks=[], yticks=[])
figure.colorbar(shown, ax=panels[:, 0], location="left", label="luminance [cd/m²]", shrink=0.6)
figure.suptitle("ON events are blue, OFF events vermilion")
plt.show()
