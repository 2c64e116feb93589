"""The whole sensor: luminance in, events and frames out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from emulator.aps import Aps, ApsFrame
from emulator.config import SensorConfig
from emulator.errors import SensorConfigError
from emulator.event_keys import Keys, unpack_keys
from emulator.events import Events, empty_events
from emulator.frames import check_luminance, check_time
from emulator.pixel_step import step_pixels
from emulator.pixels import PixelState, draw_maps, make_model, settled_state

_DEFAULT = SensorConfig()
_STREAM = 0
_KEYS_AT_FIRST = 4096


@dataclass(frozen=True, eq=False)
class SensorOutput:
    """What one step of light brought out of the sensor.

    Attributes:
        events: (n,) of `EVENT_DTYPE`, those in (time of the step before, time of this step],
            sorted by t and then by pixel; final, no later step adds to that span.
        causes: (n,) uint8, the `Cause` of each event.
        aps_frames: frames whose exposure ended in that span.
    """

    events: Events
    causes: npt.NDArray[np.uint8]
    aps_frames: tuple[ApsFrame, ...]


class Davis346:
    """A DAVIS346 that watches a scene sample by sample. It holds one frame, never a clip.

    Args:
        config: the sensor and its lens.
        seed: of everything random. Same seed, same light: the same output, bit for bit.

    Raises:
        SensorConfigError: the seed is negative or no integer.
    """

    def __init__(self, config: SensorConfig = _DEFAULT, *, seed: int):
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise SensorConfigError(
                f"the seed is {seed!r}; allowed is a whole number from 0; choose one, such as 1"
            )
        self.config = config
        rng = np.random.default_rng((int(seed), _STREAM))
        self._maps = draw_maps(config, rng)
        self._model = make_model(config, rng.integers(2**64, dtype=np.uint64))
        phase = rng.random(config.width * config.height, np.float32)
        leaks = config.leak_hz > 0.0 or config.leak_hz_per_lux > 0.0
        self._first_leak = self._maps.theta_on * (phase if leaks else np.zeros_like(phase))
        self._aps = Aps(
            config.aps,
            lux_per_cd_m2=self._model.lux_per_cd_m2,
            dark_lux=config.dark_lux,
            seed=int(seed),
        )
        self._state: PixelState | None = None
        self._first_us = 0
        self._last_us: int | None = None
        self._keys = np.empty(_KEYS_AT_FIRST, np.int64)

    def step(self, t_us: int, luminance_cd_m2: npt.ArrayLike) -> SensorOutput:
        """Take in the light at one time; the sensor takes it as ramping there from the last.

        The first call shows the sensor the scene that it has settled on, and returns nothing.
        A frame that is refused leaves the sensor as it was.

        Args:
            t_us: time of the sample, later than the last one; a Python or NumPy integer [µs].
            luminance_cd_m2: (height, width) float32 or another floating point type, which is
                rounded to float32; light of the scene at each pixel, averaged over its area
                [cd/m²]; 0 is darkness.

        Returns:
            Events and frames since the step before.

        Raises:
            FrameError: another shape, luminance that is not floating point, NaN, infinite or
                negative, a time that is no integer, goes back or stands still, or a step of
                more than 17.9 minutes.
        """
        config = self.config
        time_us = check_time(t_us, self._last_us)
        frame = check_luminance(luminance_cd_m2, width=config.width, height=config.height)
        if self._state is None or self._last_us is None:
            self._begin(time_us, frame)
            return SensorOutput(empty_events(), np.empty(0, np.uint8), ())
        from_us, self._last_us = self._last_us, time_us
        before = self._state.luminance.reshape(frame.shape)
        aps_frames = self._aps.expose(before, frame, from_us=from_us, to_us=time_us)
        keys = self._run_pixels(frame.ravel(), from_us - self._first_us, time_us - self._first_us)
        events, causes = unpack_keys(keys, start_us=from_us, width=config.width)
        return SensorOutput(events, causes, aps_frames)

    def stream(self, frames: Iterable[tuple[int, npt.ArrayLike]]) -> Iterator[SensorOutput]:
        """Step through (time [µs], luminance [cd/m²]) pairs, one output each.

        It may be called again with the frames that follow: how a sequence is cut changes nothing.

        Raises:
            FrameError: as `step` does, at the frame concerned.
        """
        for t_us, luminance_cd_m2 in frames:
            yield self.step(t_us, luminance_cd_m2)

    def _begin(self, t_us: int, frame: npt.NDArray[np.float32]) -> None:
        self._state = settled_state(frame.ravel(), self._model, self._first_leak)
        self._aps.begin(t_us, frame)
        self._first_us = self._last_us = t_us

    def _run_pixels(self, luminance: npt.NDArray[np.float32], from_us: int, to_us: int) -> Keys:
        """Take all pixels through a step, with a larger array for their events where need be."""
        assert self._state is not None
        pixel = count = 0
        while True:
            pixel, count = step_pixels(
                self._state,
                self._maps,
                self._model,
                luminance,
                from_us,
                to_us,
                self._keys,
                pixel,
                count,
            )
            if pixel == luminance.size:
                return self._keys[:count]
            self._keys = np.concatenate((self._keys, np.empty_like(self._keys)))
