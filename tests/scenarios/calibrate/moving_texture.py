"""A texture that is still and then moves past a sensor, and a lamp that blinks, in known light."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

from emulator import ApsFrame, EventSensor, SensorConfig
from emulator.characterisation.bench import chip_luminance
from flybench.events import Events, concatenate_events

WIDTH, HEIGHT = 96, 64
SPEED_PX_S = 300.0
STEP_PX = 0.25
LAMP_PX = 12
LAMP_HZ = 31.0
LAMP_LUX = (5.0, 1500.0)
"""The lamp is in a corner; it rises so far that a pixel fires at once after its reset."""
RISE_US = 40
DARKEST_LUX, BRIGHTEST_LUX = 0.03, 30.0

F64 = npt.NDArray[np.float64]


def texture(columns: int, seed: int) -> F64:
    """Log reflectance with structures of several sizes, standard deviation 0.8."""
    rng = np.random.default_rng(seed)
    layers = [
        size * gaussian_filter(rng.standard_normal((HEIGHT, columns)), size, mode="wrap")
        for size in (1.2, 3.0, 8.0)
    ]
    total = np.sum(layers, axis=0)
    return np.asarray(0.8 * (total - total.mean()) / total.std())


def illuminance(*, move_s: float, still_s: float, seed: int) -> Iterator[tuple[int, F64]]:
    """Yield time [µs] and illuminance on the chip [lux]: dark at the top, bright at the bottom."""
    pattern = texture(WIDTH + int(SPEED_PX_S * move_s) + 2, seed)
    light = np.geomspace(DARKEST_LUX, BRIGHTEST_LUX, HEIGHT)[:, None]
    step_us = round(1e6 * STEP_PX / SPEED_PX_S)

    def image(steps: int, lit: bool) -> F64:
        first, part = divmod(SPEED_PX_S * steps * step_us * 1e-6, 1.0)
        k = int(first)
        view = (1 - part) * pattern[:, k : k + WIDTH] + part * pattern[:, k + 1 : k + 1 + WIDTH]
        lux = light * np.exp(view)
        lux[-LAMP_PX:, -LAMP_PX:] = LAMP_LUX[lit]
        return np.asarray(lux)

    start_us = round(1e6 * still_s)
    yield 0, image(0, False)
    yield start_us // 2, image(0, False)
    yield start_us, image(0, False)
    lit = False
    steps = int(move_s * 1e6 / step_us)
    for k in range(1, steps + 1):
        t_us = start_us + k * step_us
        now = int(2e-6 * LAMP_HZ * t_us) % 2 == 1
        if now != lit:
            yield t_us - step_us + RISE_US, image(k - 1, now)
        lit = now
        yield t_us, image(k, lit)


@lru_cache(maxsize=4)
def recorded(
    sensor: SensorConfig, *, move_s: float = 0.7, still_s: float = 5.0, seed: int = 0
) -> tuple[Events, tuple[ApsFrame, ...]]:
    """Return events and frames of a sensor that sees the texture."""
    camera = EventSensor(sensor, seed=seed + 1)
    events: list[Events] = []
    frames: list[ApsFrame] = []
    for t_us, lux in illuminance(move_s=move_s, still_s=still_s, seed=seed):
        output = camera.step(t_us, chip_luminance(sensor, lux))
        events.append(output.events)
        frames += output.aps_frames
    return concatenate_events(events), tuple(frames)
