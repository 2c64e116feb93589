"""The whole sensor, from luminance to events with their causes, and to frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from emulator.aps.frames import Aps, ApsFrame
from emulator.arguments import check_config, check_seed, check_threads
from emulator.config import SensorConfig
from emulator.luminance_frames import (
    Rectangle,
    check_frame,
    check_luminance,
    check_rectangle,
    check_time,
    time_luminance_pairs,
)
from emulator.pixel.active_pixels import (
    ThreadShare,
    empty_masks,
    find_active,
    mark_all_blocks,
    mark_blocks_within,
)
from emulator.pixel.batch import empty_batch
from emulator.pixel.noisy.settle import settle
from emulator.pixel.state import (
    Pixels,
    PixelState,
    StepTimes,
    draw_pixels,
    make_model,
    settled_state,
)
from emulator.pixel.step import step_pixels
from emulator.readout.arbiter import Arbiter
from emulator.readout.config import UNLIMITED_HZ, ReadoutKind
from emulator.readout.event_keys import Keys, unpack_keys
from emulator.readout.latency import FixedLatency
from emulator.readout.scan import Scan
from emulator.readout.stats import ReadoutStats
from emulator.thread_pool import ThreadPool
from flybench.events import Cause, Events, empty_events
from flybench.memory import OPTION, VARIABLE, MemoryBudgetError, count_memory, free_bytes
from flybench.printable import html_table

_DEFAULT = SensorConfig()
_RANDOM_STREAM = 0
_INITIAL_KEYS = 4096
_BYTES_PER_PX, _BYTES_PER_EVENT = 150, 100
"""Memory per pixel (measured: 118 to 131), and per event of a step: its key, its place in the
readout's queue and its copies (estimated) [bytes]."""


@dataclass(frozen=True, eq=False)
class SensorOutput:
    """Output of one sensor step.

    Attributes:
        events: (n,) of `EVENT_DTYPE`, the events with time stamps in (time of the previous step,
            time of this step], sorted by t and then by pixel. They are final: no later step adds
            events to that interval. Events that are not read out by the end of the step are
            returned by a later one.
        causes: (n,) uint8, the `Cause` of each event.
        aps_frames: frames whose exposure ended in that interval.
        readout: what the readout did: counts of events offered, delayed, dropped and waiting.
    """

    events: Events
    causes: npt.NDArray[np.uint8]
    aps_frames: tuple[ApsFrame, ...]
    readout: ReadoutStats = field(default_factory=ReadoutStats)

    def _repr_html_(self) -> str:
        on = int(np.count_nonzero(self.events["p"]))
        rows = {
            "events": f"{self.events.size:,}",
            "ON, OFF": f"{on:,}, {self.events.size - on:,}",
            "signal": f"{np.count_nonzero(self.causes == Cause.SIGNAL):,}",
            "APS frames": f"{len(self.aps_frames)}",
        }
        return html_table("output of a sensor step", rows)


class EventSensor:
    """An event sensor that observes a scene sample by sample; it stores only the last frame.

    Args:
        config: the sensor and its lens; a DAVIS346 by default.
        seed: seed of all random numbers. The same seed and the same luminance give the same output,
            bit for bit.
        threads: number of threads that share a step, 1 to 64. It changes only the time that a step
            takes. At 346×260, two threads are slower than one.

    Raises:
        SensorConfigError: `config` is not a `SensorConfig`, the seed is negative or not an integer,
            or the number of threads is out of range.
        MemoryBudgetError: the sensor is too large for the memory budget.
    """

    def __init__(self, config: SensorConfig = _DEFAULT, *, seed: int, threads: int = 1):
        self.config = check_config(config)
        seed, threads = check_seed(seed), check_threads(threads)
        count_memory(self, f"A sensor of {config.width}×{config.height} px", sensor_bytes(config))
        rng = np.random.default_rng((seed, _RANDOM_STREAM))
        self._pixels = draw_pixels(config, rng)
        self._model = make_model(config, rng.integers(2**64, dtype=np.uint64))
        _draw_leak_phases(self._pixels, config, rng)
        self._aps = Aps(
            config.aps,
            lux_per_cd_m2=self._model.lux_per_cd_m2,
            dark_lux=self._model.dark_lux,
            seed=seed,
        )
        self._readout = _make_readout(config)
        self._state: PixelState | None = None
        self._first_us = 0
        self._last_us: int | None = None
        self._active = empty_masks(config.width * config.height)
        self._shares = [ThreadShare(part, threads) for part in range(threads)]
        self._keys = [np.empty(_INITIAL_KEYS, np.int64) for _ in range(threads)]
        self._batches = [empty_batch() for _ in range(threads)]
        self._pool = ThreadPool(threads)

    def step(
        self, t_us: int, luminance_cd_m2: npt.ArrayLike, *, changed: Rectangle | None = None
    ) -> SensorOutput:
        """Advance the sensor to the next sample of luminance.

        Between two samples, the luminance of each pixel is taken to change linearly for the frames,
        and the logarithm of its illuminance for the events. The first call gives the scene to which
        the sensor has settled, and returns no events. A frame that is refused leaves the sensor
        unchanged.

        Args:
            t_us: time of the sample, later than the last one; a Python or NumPy integer [µs].
            luminance_cd_m2: (height, width) float32 or another floating point type, which is
                rounded to float32; luminance of the scene at each pixel, averaged over its area
                [cd/m²]; 0 is darkness.
            changed: x0, y0, x1, y1 of a rectangle, the last two exclusive, outside of which no
                luminance has changed since the previous step. The sensor does not compare the
                pixels outside, which saves time. None: not known.

        Returns:
            Events and frames since the previous step.

        Raises:
            FrameError: wrong shape; luminance that is not floating point, NaN, infinite or
                negative; a time that is no integer or not later than the last; a step longer than
                17.9 minutes or than 1000 APS frames (25 s at the default 40 frames/s); or an
                invalid rectangle.
            MemoryBudgetError: the frames or the events of this step are too many for the memory
                budget. If it was the events, the sensor cannot be used any more.
        """
        config = self.config
        time_us = check_time(t_us, self._last_us)
        frame = check_frame(luminance_cd_m2, width=config.width, height=config.height)
        if self._state is None or self._last_us is None:
            self._begin(time_us, frame)
            return SensorOutput(empty_events(), np.empty(0, np.uint8), ())
        self._aps.check_step(time_us - self._last_us)
        times = StepTimes(self._last_us - self._first_us, time_us - self._first_us)
        self._find_active(self._state, frame, times, changed)
        before = self._state.luminance.reshape(frame.shape)
        aps_frames = self._aps.expose(
            before, frame, self._active.changed, from_us=self._last_us, to_us=time_us
        )
        keys = self._step_pixels(self._state, frame.ravel(), times)
        keys.sort()
        keys, stats = self._readout.read_out(keys, from_us=times.from_us, to_us=times.to_us)
        events, causes = unpack_keys(keys, start_us=self._last_us, width=config.width)
        self._last_us = time_us
        return SensorOutput(events, causes, aps_frames, stats)

    def stream(self, frames: Iterable[tuple[int, npt.ArrayLike]]) -> Iterator[SensorOutput]:
        """Step through pairs of (time [µs], luminance [cd/m²]) and yield one output for each.

        A second call continues the sequence. Where a sequence is cut does not change the output.

        Raises:
            FrameError: a frame is invalid, as in `step`; or an item is not a pair.
        """
        for t_us, luminance_cd_m2 in time_luminance_pairs(frames):
            yield self.step(t_us, luminance_cd_m2)

    def _begin(self, t_us: int, frame: npt.NDArray[np.float32]) -> None:
        check_luminance(frame)
        self._state = settled_state(frame.ravel(), self._model, self._pixels)
        if self._model.sigma_0 > 0.0:
            settle(self._state, self._model, self._batches[0])
        self._aps.begin(t_us, frame)
        self._first_us = self._last_us = t_us

    def _find_active(
        self,
        state: PixelState,
        frame: npt.NDArray[np.float32],
        times: StepTimes,
        changed: Rectangle | None,
    ) -> None:
        """Find the pixels that must be computed, and refuse invalid luminance."""
        width, height = self.config.width, self.config.height
        if changed is None:
            mark_all_blocks(self._active.compare)
        else:
            rectangle = check_rectangle(changed, width=width, height=height)
            mark_blocks_within(self._active.compare, rectangle, width)
        luminance = frame.ravel()
        valid = self._pool.run(
            lambda part: find_active(
                state, luminance, times.to_us, self._active, self._shares[part]
            )
        )
        if not all(valid):
            check_luminance(frame)

    def _step_pixels(
        self, state: PixelState, luminance: npt.NDArray[np.float32], times: StepTimes
    ) -> Keys:
        """Take all pixels through one step, and return the keys of their events, unsorted."""
        most = free_bytes() // _BYTES_PER_EVENT // len(self._keys)

        def run(part: int) -> Keys:
            self._keys[part], used = step_pixels(
                state,
                self._model,
                luminance,
                times,
                self._active,
                self._shares[part],
                self._batches[part],
                self._keys[part],
                most,
            )
            return self._keys[part][:used]

        try:
            found = self._pool.run(run)
        except MemoryError:
            raise MemoryBudgetError(
                f"The step from {times.from_us} to {times.to_us} µs gives more than {most} events, "
                "which do not fit into the memory budget. Take shorter steps, or allow more with "
                f"{OPTION} (in Python: the environment variable {VARIABLE})."
            ) from None
        return found[0] if len(found) == 1 else np.concatenate(found)


def sensor_bytes(config: SensorConfig) -> int:
    """Return the memory of a sensor without its events [bytes]."""
    return _BYTES_PER_PX * config.width * config.height


class Davis346(EventSensor):
    """An `EventSensor` under the name of its default configuration."""


def _draw_leak_phases(pixels: Pixels, config: SensorConfig, rng: np.random.Generator) -> None:
    """Start the leak of each pixel at a random fraction of its ON threshold.

    The phases are drawn even if they are not used, so that later random numbers stay the same.
    """
    phase = rng.random(pixels.size, np.float32)
    if config.leak_hz > 0.0 or config.leak_hz_per_lux > 0.0:
        theta_on = pixels["theta_on"]
        pixels["leak"] = np.where(np.isfinite(theta_on), theta_on * phase, 0.0)


def _make_readout(config: SensorConfig) -> Arbiter | FixedLatency | Scan:
    """Return the readout of a sensor."""
    readout = config.readout
    if readout.kind is ReadoutKind.SCAN:
        return Scan(period_us=readout.scan_period_us, latency_us=readout.latency_us)
    if readout.limit_hz >= UNLIMITED_HZ:
        return FixedLatency(readout.latency_us)
    return Arbiter(
        width=config.width,
        height=config.height,
        config=readout,
        refractory_us=config.refractory_us,
    )
