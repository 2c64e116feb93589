"""The whole sensor: luminance in, events and frames out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from emulator.aps.frames import Aps, ApsFrame
from emulator.arguments import check_config, check_seed, check_threads
from emulator.config import UNLIMITED_HZ, SensorConfig
from emulator.luminance_frames import (
    Rectangle,
    check_frame,
    check_luminance,
    check_rectangle,
    check_time,
    pairs,
)
from emulator.pixel.batch import empty_batch
from emulator.pixel.scan import find_work, look_everywhere, look_within, no_work
from emulator.pixel.state import Pixels, PixelState, draw_pixels, make_model, settled_state
from emulator.pixel.step import step_pixels
from emulator.readout.arbiter import Arbiter, Latency, Readout
from emulator.readout.event_keys import Keys, unpack_keys
from emulator.thread_pool import ThreadPool
from flybench.events import Events, empty_events

_DEFAULT = SensorConfig()
_STREAM = 0
_KEYS_AT_FIRST = 4096


@dataclass(frozen=True, eq=False)
class SensorOutput:
    """What one step of light brought out of the sensor.

    Attributes:
        events: (n,) of `EVENT_DTYPE`, those read out in (time of the step before, time of this
            step], sorted by t and then by pixel; final, no later step adds to that span. What the
            row arbiter has not granted by the end of the step leaves in a later one.
        causes: (n,) uint8, the `Cause` of each event.
        aps_frames: frames whose exposure ended in that span.
        readout: what the row arbiter did: events offered, delayed, dropped and waiting.
    """

    events: Events
    causes: npt.NDArray[np.uint8]
    aps_frames: tuple[ApsFrame, ...]
    readout: Readout = field(default_factory=Readout)


class Davis346:
    """A DAVIS346 that watches a scene sample by sample. It holds one frame, never a clip.

    Args:
        config: the sensor and its lens.
        seed: of everything random. Same seed, same light: the same output, bit for bit.
        threads: how many share a step, 1 to 64; their number changes nothing but the time it takes.
            At 346×260 two are slower than one.

    Raises:
        SensorConfigError: what is given is no `SensorConfig`, the seed is negative or no integer,
            or there are no threads.
    """

    def __init__(self, config: SensorConfig = _DEFAULT, *, seed: int, threads: int = 1):
        self.config = check_config(config)
        seed, threads = check_seed(seed), check_threads(threads)
        rng = np.random.default_rng((seed, _STREAM))
        self._pixels = draw_pixels(config, rng)
        self._model = make_model(config, rng.integers(2**64, dtype=np.uint64))
        _draw_leak_phases(self._pixels, config, rng)
        self._aps = Aps(
            config.aps,
            lux_per_cd_m2=self._model.lux_per_cd_m2,
            dark_lux=self._model.dark_lux,
            seed=seed,
        )
        self._arbiter = _readout_of(config)
        self._state: PixelState | None = None
        self._first_us = 0
        self._last_us: int | None = None
        self._work = no_work(config.width * config.height)
        self._keys = [np.empty(_KEYS_AT_FIRST, np.int64) for _ in range(threads)]
        self._batches = [empty_batch() for _ in range(threads)]
        self._crew = ThreadPool(threads)

    def step(
        self, t_us: int, luminance_cd_m2: npt.ArrayLike, *, changed: Rectangle | None = None
    ) -> SensorOutput:
        """Take in the light at one time; the sensor takes it as ramping there from the last.

        The first call shows the sensor the scene that it has settled on, and returns nothing.
        A frame that is refused leaves the sensor as it was.

        Args:
            t_us: time of the sample, later than the last one; a Python or NumPy integer [µs].
            luminance_cd_m2: (height, width) float32 or another floating point type, which is
                rounded to float32; light of the scene at each pixel, averaged over its area
                [cd/m²]; 0 is darkness.
            changed: x0, y0, x1, y1 of a rectangle, the last two exclusive, outside of which no
                light has changed since the step before: what is outside is not looked at, which
                saves time. None if it is not known.

        Returns:
            Events and frames since the step before.

        Raises:
            FrameError: another shape, luminance that is not floating point, NaN, infinite or
                negative, a time that is no integer, goes back or stands still, a step of more
                than 17.9 minutes or of more than 1000 APS frames (25 s at the default 40
                frames/s), or a rectangle that is none.
        """
        config = self.config
        time_us = check_time(t_us, self._last_us)
        frame = check_frame(luminance_cd_m2, width=config.width, height=config.height)
        if self._state is None or self._last_us is None:
            self._begin(time_us, frame)
            return SensorOutput(empty_events(), np.empty(0, np.uint8), ())
        self._aps.check_step(time_us - self._last_us)
        from_us, to_us = self._last_us - self._first_us, time_us - self._first_us
        self._find_work(self._state, frame, to_us, changed)
        before = self._state.luminance.reshape(frame.shape)
        aps_frames = self._aps.expose(
            before, frame, self._work.changed, from_us=self._last_us, to_us=time_us
        )
        keys = self._run_pixels(self._state, frame.ravel(), from_us, to_us)
        keys.sort()
        keys, readout = self._arbiter.read_out(keys, from_us=from_us, to_us=to_us)
        events, causes = unpack_keys(keys, start_us=self._last_us, width=config.width)
        self._last_us = time_us
        return SensorOutput(events, causes, aps_frames, readout)

    def stream(self, frames: Iterable[tuple[int, npt.ArrayLike]]) -> Iterator[SensorOutput]:
        """Step through (time [µs], luminance [cd/m²]) pairs, one output each.

        It may be called again with the frames that follow: how a sequence is cut changes nothing.

        Raises:
            FrameError: as `step` does, at the frame concerned, or an item that is no pair.
        """
        for t_us, luminance_cd_m2 in pairs(frames):
            yield self.step(t_us, luminance_cd_m2)

    def _begin(self, t_us: int, frame: npt.NDArray[np.float32]) -> None:
        check_luminance(frame)
        self._state = settled_state(frame.ravel(), self._model, self._pixels)
        self._aps.begin(t_us, frame)
        self._first_us = self._last_us = t_us

    def _find_work(
        self,
        state: PixelState,
        frame: npt.NDArray[np.float32],
        to_us: int,
        changed: Rectangle | None,
    ) -> None:
        """Find the pixels that have work, and refuse light that is none."""
        width, height = self.config.width, self.config.height
        if changed is None:
            look_everywhere(self._work.look)
        else:
            rectangle = check_rectangle(changed, width=width, height=height)
            look_within(self._work.look, rectangle, width)
        parts, luminance = len(self._batches), frame.ravel()
        if not all(
            self._crew.share(
                lambda part: find_work(state, luminance, to_us, self._work, part, parts)
            )
        ):
            check_luminance(frame)

    def _run_pixels(
        self, state: PixelState, luminance: npt.NDArray[np.float32], from_us: int, to_us: int
    ) -> Keys:
        """Take all pixels through a step."""
        parts = len(self._batches)

        def run(part: int) -> Keys:
            batch, keys = self._batches[part], self._keys[part]
            self._keys[part], used = step_pixels(
                state, self._model, luminance, from_us, to_us, self._work, part, parts, batch, keys
            )
            return self._keys[part][:used]

        found = self._crew.share(run)
        return found[0] if parts == 1 else np.concatenate(found)


def _draw_leak_phases(pixels: Pixels, config: SensorConfig, rng: np.random.Generator) -> None:
    """Start the leak of each pixel somewhere on its way to the threshold.

    The phases are drawn even if they are not used: what is drawn after them stays the same.
    """
    phase = rng.random(pixels.size, np.float32)
    if config.leak_hz > 0.0 or config.leak_hz_per_lux > 0.0:
        theta_on = pixels["theta_on"]
        pixels["leak"] = np.where(np.isfinite(theta_on), theta_on * phase, 0.0)


def _readout_of(config: SensorConfig) -> Arbiter | Latency:
    """What reads the events out."""
    if config.readout_limit_hz >= UNLIMITED_HZ:
        return Latency(config.readout_latency_us)
    return Arbiter(
        width=config.width,
        height=config.height,
        limit_hz=config.readout_limit_hz,
        latency_us=config.readout_latency_us,
        refractory_us=config.refractory_us,
    )
