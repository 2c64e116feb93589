"""Compare event images from flybench, tonic and dv-processing for the same events.

    pip install 'flybench[peers]'          # in a clone: .venv/bin/pip install -e '.[peers]'
    python examples/peers.py --picture peers.png                 # an emulated disc
    python examples/peers.py logs/demo/day/events.h5 --start-ms 600 --picture peers.png

1. flybench writes the events as AEDAT4, and dv-processing reads that file with its own reader.
   tonic reads the event array directly, by the names of its fields.
2. Each library makes its own two images: the number of ON and OFF events of each pixel (tonic's
   `to_frame`, dv-processing's `Accumulator`), and the time surface, exp(-age / tau) of each pixel's
   last event (tonic's `to_timesurface`, dv-processing's `TimeSurface`). flybench's images are made
   with NumPy.
3. The counts must be equal, and the surfaces equal to rounding. Otherwise the exit status is 1.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import dv_processing as dv
import numpy as np
import tonic
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from flybench import Events, EventSensor, SensorConfig, open_events, open_writer
from scenarios.output.colours import OFF, ON, hex_of

TAU_US = 10_000.0
"""Time constant of the time surfaces [µs]."""
ROUNDING = 1e-12
"""Largest difference between two time surfaces that counts as rounding."""


def emulated_disc() -> tuple[Events, tuple[int, int]]:
    """Emulate a DAVIS346 that sees a bright disc move right at 500 px/s for 60 ms."""
    sensor = EventSensor(SensorConfig(), seed=1)
    y, x = np.mgrid[:260, :346]
    events = []
    for t_us in range(0, 60_000, 1000):
        inside = 40.5 - np.hypot(x - 120 - 500e-6 * t_us, y - 130)
        output = sensor.step(t_us, 20 + 80 * np.clip(inside, 0, 1))
        events.append(output.events)
    return np.concatenate(events), (346, 260)


def from_file(path: Path, start_us: int, span_us: int) -> tuple[Events, tuple[int, int]]:
    """Read the events of one part of a recording in any supported format."""
    found = []
    with open_events(path) as file:
        for chunk in file:
            times_us = chunk.events["t"]
            found.append(chunk.events[(times_us >= start_us) & (times_us < start_us + span_us)])
            if times_us.size and times_us[-1] >= start_us + span_us:
                break
        return np.concatenate(found), (file.width, file.height)


def our_pictures(events: Events, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Make flybench's images.

    Returns:
        (2, rows, columns) numbers of OFF and ON events, and their time surfaces.
    """
    counts = np.zeros((2, size[1], size[0]), np.int64)
    np.add.at(counts, (events["p"].astype(int), events["y"], events["x"]), 1)
    last_us = np.full((2, size[1], size[0]), -np.inf)
    # For repeated indices NumPy keeps the last value, which is that of the last event.
    last_us[events["p"].astype(int), events["y"], events["x"]] = events["t"]
    return counts, np.exp((last_us - events["t"][-1]) / TAU_US)


def tonic_pictures(events: Events, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Make tonic's images, like `our_pictures`.

    tonic computes its surface at the end of a time window that starts at the first event, 1 µs
    after the last event.
    """
    columns = (events[name] for name in ("x", "y", "t", "p"))
    structured = tonic.io.make_structured_array(*columns)
    shape = (*size, 2)
    frame = tonic.functional.to_frame_numpy(structured, shape, n_event_bins=1)[0]
    window_us = int(events["t"][-1] - events["t"][0])
    surface = tonic.functional.to_timesurface_numpy(
        structured, shape, dt=window_us + 1, tau=TAU_US, include_incomplete=True
    )[0]
    return frame.astype(np.int64), surface * np.exp(1 / TAU_US)  # at the last event, as ours


def dv_pictures(events: Events, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Make dv-processing's images, like `our_pictures`, from an AEDAT4 file written by flybench."""
    store = _read_by_dv(events, size)
    counts, surfaces = [], []
    for polarity in (False, True):
        polarity_filter = dv.EventPolarityFilter(polarity)
        polarity_filter.accept(store)
        filtered = polarity_filter.generateEvents()
        counter = dv.Accumulator(
            size, dv.Accumulator.Decay.NONE, 1.0, False, 1.0, 1e6, 0.0, 0.0, True
        )
        counter.accept(filtered)
        counts.append(np.array(counter.getPotentialSurface()).round().astype(np.int64))
        last_us = _last_times_us(filtered, size)
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


def _last_times_us(store: dv.EventStore, size: tuple[int, int]) -> np.ndarray:
    surface = dv.TimeSurface(size)
    surface.accept(store)
    return np.array([[surface.at(y, x) for x in range(size[0])] for y in range(size[1])])


def plot(path: Path, pictures: dict[str, tuple[np.ndarray, np.ndarray]]) -> None:
    """Plot one column per library: ON minus OFF events above, the later time surface below."""
    figure = Figure(figsize=(12, 6.4), layout="constrained")
    polarity = LinearSegmentedColormap.from_list("polarity", [hex_of(OFF), "white", hex_of(ON)])
    for column, (name, (counts, surface)) in enumerate(pictures.items()):
        above, below = (figure.add_subplot(2, 3, 3 * row + column + 1) for row in (0, 1))
        balance = counts[1] - counts[0]
        limit = max(1, np.abs(balance).max())
        above.imshow(balance, cmap=polarity, vmin=-limit, vmax=limit, interpolation="nearest")
        below.imshow(surface.max(axis=0), cmap="inferno", vmin=0, interpolation="nearest")
        above.set_title(f"{name}: ON minus OFF")
        below.set_title(f"{name}: time surface, {TAU_US / 1000:g} ms")
        for axes in (above, below):
            axes.set_xticks([])
            axes.set_yticks([])
    figure.savefig(path, dpi=100)


def main() -> int:
    """Make the images of all libraries, compare them, and plot them side by side."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "file", type=Path, nargs="?", help="recording to read; default: emulate a disc"
    )
    parser.add_argument(
        "--start-ms",
        type=float,
        default=0.0,
        help="start of the part to read [ms] (default: %(default)g)",
    )
    parser.add_argument(
        "--span-ms",
        type=float,
        default=30.0,
        help="length of that part [ms] (default: %(default)g)",
    )
    parser.add_argument("--picture", type=Path, help="PNG file to write")
    arguments = parser.parse_args()
    if arguments.file is None:
        events, size = emulated_disc()
    else:
        span_us = int(arguments.span_ms * 1000)
        events, size = from_file(arguments.file, int(arguments.start_ms * 1000), span_us)
    if not events.size:
        print(f"{arguments.file} has no events in this part. Choose another with --start-ms.")
        return 2
    pictures = {
        "ours": our_pictures(events, size),
        f"tonic {tonic.__version__}": tonic_pictures(events, size),
        f"dv-processing {dv.__version__}": dv_pictures(events, size),
    }
    if arguments.picture:
        plot(arguments.picture, pictures)
    return compare(pictures, events.size)


def compare(pictures: dict[str, tuple[np.ndarray, np.ndarray]], number: int) -> int:
    """Print how much each library's images differ from the first library's.

    Args:
        pictures: counts and time surfaces of each library.
        number: number of events.

    Returns:
        Exit status: 0 if all images agree, else 1.
    """
    (_, (counts, surface)), *others = pictures.items()
    print(f"{number:,} events, {counts[1].sum():,} ON and {counts[0].sum():,} OFF")
    same = counts.sum() == number
    for name, (other_counts, other_surface) in others:
        count_difference = int(np.abs(other_counts - counts).max())
        difference = float(np.abs(other_surface - surface).max())
        same = same and count_difference == 0 and difference < ROUNDING
        print(f"{name}: counts differ by {count_difference}, time surfaces by {difference:.1g}")
    print("the same picture" if same else "NOT the same picture")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
