"""Print where the fly is right in the noise of the emulated sensor: `python -m tools.own_noise`.

The stimuli are those of the first table of the operating range. Their Poisson noise is replaced by
that of the default sensor in still, dim light, in which it has the most.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from emulator import EventSensor, SensorConfig
from emulator.characterisation.bench import bench_sensor, chip_luminance, uniform_frame
from flybench.direction import CARDINAL
from flybench.events import Events, concatenate_events
from scenarios.envelope import drawing
from scenarios.envelope.grid import BASE
from scenarios.envelope.measure import measure

METHODS = ("fly", "wide", "robust")
SPEEDS_PX_S = (30.0, 60.0, 100.0, 160.0, 350.0, 790.0, 1500.0, 2000.0)
CHIP_LUX = 0.46
STEP_US = 100_000


def sensor_noise(
    _rate_hz: float, *, width: int, height: int, duration_us: int, rng: np.random.Generator
) -> Events:
    """Return what the default sensor gives of still light of `CHIP_LUX`; see `poisson_noise`."""
    sensor = bench_sensor(SensorConfig(), width=width, height=height)
    still = uniform_frame(sensor, chip_luminance(sensor, CHIP_LUX))
    camera = EventSensor(sensor, seed=int(rng.integers(2**31)))
    ends = [*range(0, duration_us, STEP_US), duration_us]
    events = concatenate_events([camera.step(t_us, still).events for t_us in ends])
    return events[events["t"] < duration_us]


def main() -> None:
    """Print the table as Markdown."""
    drawing.poisson_noise = sensor_noise  # the stimuli have no other noise
    print("| image speed [px/s] |", " | ".join(f"{v:g}" for v in SPEEDS_PX_S), "|")
    print("| --- |" + " --- |" * len(SPEEDS_PX_S))
    right: dict[str, list[float]] = {name: [] for name in METHODS}
    for speed in SPEEDS_PX_S:
        points = [replace(BASE, speed_px_s=speed, direction=d) for d in CARDINAL]
        rows = [row for point in points for row in measure(point, METHODS)]
        for name in METHODS:
            shares = [row["accuracy_after_100ms"] for row in rows if row["method"] == name]
            right[name].append(100.0 * float(np.mean(shares)))
    for name in METHODS:
        print(f"| `{name}` |", " | ".join(f"{x:.0f} %" for x in right[name]), "|", flush=True)


if __name__ == "__main__":
    main()
