"""The same events in three hands: ours, tonic's and dv-processing's, and they see the same picture.

    pip install 'flybench[peers]'          # in a clone: .venv/bin/pip install -e '.[peers]'
    python examples/peers.py --picture peers.png                 # a disc that we emulate
    python examples/peers.py logs/demo/day/events.h5 --start-ms 600 --picture peers.png

1. We write the events as AEDAT4 with `formats.open_writer`; dv-processing reads that file with its
   own reader. tonic takes the array as it is, by the names of its columns.
2. Each makes its own pictures of them: how many ON and OFF events each pixel had (tonic's
   `to_frame`, dv-processing's `Accumulator`), and a time surface, exp(-age / tau) of each pixel's
   last event (tonic's `to_timesurface`, dv-processing's `TimeSurface`); ours are NumPy.
3. Counts must be equal, and surfaces equal to rounding. Where they are not, the exit status is 1.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import dv_processing as dv
import numpy as np
import tonic
from matplotlib.figure import Figure

from emulator import EventSensor, SensorConfig
from flybench.events import Events
from formats import open_events, open_writer

TAU_US = 10_000.0
ROUNDING = 1e-12


def emulated_disc() -> tuple[Events, tuple[int, int]]:
    """A bright disc that moves to the right at 500 px/s, as a DAVIS346 sees it for 60 ms."""
    sensor = EventSensor(SensorConfig(), seed=1)
    y, x = np.mgrid[:260, :346]
    events = []
    for t_us in range(0, 60_000, 1000):
        inside = 40.5 - np.hypot(x - 120 - 500e-6 * t_us, y - 130)
        output = sensor.step(t_us, 20 + 80 * np.clip(inside, 0, 1))
        events.append(output.events)
    return np.concatenate(events), (346, 260)


def from_file(path: Path, start_us: int, span_us: int) -> tuple[Events, tuple[int, int]]:
    """Events of a part of a recording of any format."""
    found = []
    with open_events(path) as file:
        for chunk in file:
            times_us = chunk.events["t"]
            found.append(chunk.events[(times_us >= start_us) & (times_us < start_us + span_us)])
            if times_us.size and times_us[-1] >= start_us + span_us:
                break
        return np.concatenate(found), (file.width, file.height)


def our_pictures(events: Events, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(2, rows, columns) counts of OFF and ON, and the surface of the last event of either."""
    counts = np.zeros((2, size[1], size[0]), np.int64)
    np.add.at(counts, (events["p"].astype(int), events["y"], events["x"]), 1)
    last_us = np.full((2, size[1], size[0]), -np.inf)
    last_us[events["p"].astype(int), events["y"], events["x"]] = events["t"]  # the last one stays
    return counts, np.exp((last_us - events["t"][-1]) / TAU_US)


def tonics_pictures(events: Events, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """The same by tonic, whose surface is that at a whole time window after the first event."""
    columns = (events[name] for name in ("x", "y", "t", "p"))
    theirs = tonic.io.make_structured_array(*columns)
    shape = (*size, 2)
    frame = tonic.functional.to_frame_numpy(theirs, shape, n_event_bins=1)[0]
    window_us = int(events["t"][-1] - events["t"][0])
    surface = tonic.functional.to_timesurface_numpy(
        theirs, shape, dt=window_us + 1, tau=TAU_US, include_incomplete=True
    )[0]
    return frame.astype(np.int64), surface * np.exp(1 / TAU_US)  # from the last event, not 1 µs on


def dvs_pictures(events: Events, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """The same by dv-processing, from an AEDAT4 file that we wrote and it reads."""
    store = _read_by_dv(events, size)
    counts, surfaces = [], []
    for polarity in (False, True):
        only = dv.EventPolarityFilter(polarity)
        only.accept(store)
        own = only.generateEvents()
        counter = dv.Accumulator(
            size, dv.Accumulator.Decay.NONE, 1.0, False, 1.0, 1e6, 0.0, 0.0, True
        )
        counter.accept(own)
        counts.append(np.array(counter.getPotentialSurface()).round().astype(np.int64))
        last_us = _last_times(own, size)
        age_us = np.where(counts[-1] > 0, store.getHighestTime() - last_us, np.inf)
        surfaces.append(np.exp(-age_us / TAU_US))
    return np.array(counts), np.array(surfaces)


def _read_by_dv(events: Events, size: tuple[int, int]) -> dv.EventStore:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "events.aedat4"
        with open_writer(path, width=size[0], height=size[1]) as writer:
            writer.write(events)
        recording, store = dv.io.MonoCameraRecording(str(path)), dv.EventStore()
        while (batch := recording.getNextEventBatch()) is not None:
            store.add(batch)
    return store


def _last_times(store: dv.EventStore, size: tuple[int, int]) -> np.ndarray:
    surface = dv.TimeSurface(size)
    surface.accept(store)
    return np.array([[surface.at(y, x) for x in range(size[0])] for y in range(size[1])])


def draw(path: Path, pictures: dict[str, tuple[np.ndarray, np.ndarray]]) -> None:
    """ON minus OFF above, the younger of both surfaces below, a column each."""
    figure = Figure(figsize=(12, 6.4), layout="constrained")
    for column, (name, (counts, surface)) in enumerate(pictures.items()):
        above, below = (figure.add_subplot(2, 3, 3 * row + column + 1) for row in (0, 1))
        balance = counts[1] - counts[0]
        far = max(1, np.abs(balance).max())
        above.imshow(balance, cmap="RdBu_r", vmin=-far, vmax=far, interpolation="nearest")
        below.imshow(surface.max(axis=0), cmap="inferno", vmin=0, interpolation="nearest")
        above.set_title(f"{name}: ON minus OFF")
        below.set_title(f"{name}: time surface, {TAU_US / 1000:g} ms")
        for axes in (above, below):
            axes.set_xticks([])
            axes.set_yticks([])
    figure.savefig(path, dpi=100)


def main() -> int:
    """Make the pictures, compare them, and draw them side by side."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, nargs="?", help="a recording; else a disc is emulated")
    parser.add_argument("--start-ms", type=float, default=0.0, help="of the part that is taken")
    parser.add_argument("--span-ms", type=float, default=30.0, help="how long it is")
    parser.add_argument("--picture", type=Path, help="PNG to write")
    arguments = parser.parse_args()
    if arguments.file is None:
        events, size = emulated_disc()
    else:
        span_us = int(arguments.span_ms * 1000)
        events, size = from_file(arguments.file, int(arguments.start_ms * 1000), span_us)
    if not events.size:
        print(f"{arguments.file} has no event in that part; choose another with --start-ms")
        return 2
    pictures = {
        "ours": our_pictures(events, size),
        f"tonic {tonic.__version__}": tonics_pictures(events, size),
        f"dv-processing {dv.__version__}": dvs_pictures(events, size),
    }
    if arguments.picture:
        draw(arguments.picture, pictures)
    return compare(pictures, events.size)


def compare(pictures: dict[str, tuple[np.ndarray, np.ndarray]], number: int) -> int:
    """Print how far each picture is from ours; 0 where all are the same, else 1."""
    (_, (counts, surface)), *others = pictures.items()
    print(f"{number:,} events, {counts[1].sum():,} ON and {counts[0].sum():,} OFF")
    same = counts.sum() == number
    for name, (their_counts, their_surface) in others:
        off = int(np.abs(their_counts - counts).max())
        far = float(np.abs(their_surface - surface).max())
        same = same and off == 0 and far < ROUNDING
        print(f"{name}: counts differ by {off}, time surfaces by {far:.1g}")
    print("the same picture" if same else "NOT the same picture")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
