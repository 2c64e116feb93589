"""Samples of a dataset: a slice of events, and the labels of one time."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from detector.fly.config import FlyConfig
from detector.fly.time_surface import TimeSurfaces
from flybench.events import Events
from flybench.files import read_small_text
from scenarios.dataset.layout import EVENTS, label_times_us
from scenarios.datasets.label_reading import READABLE, SequenceLabels
from scenarios.datasets.slicing import Slicing, read_events
from scenarios.datasets.voxel_grid import voxel_grid
from scenarios.errors import ScenarioError
from scenarios.output.atomic_folder import GENERATOR, SUMMARY

BINS = 15
"""Default number of bins of a voxel grid, that of DSEC's example."""
_OPEN_FILES = 64
"""Most files that a process keeps open (assumed: far below the usual limit of 1024)."""


class Representation(StrEnum):
    """Forms of the events in a sample."""

    EVENTS = "events"
    VOXEL_GRID = "voxel_grid"
    TIME_SURFACE = "time_surface"


class EventDataset:
    """A map-style dataset for PyTorch's DataLoader; it needs no PyTorch itself.

    One sample belongs to one label of one sequence. It is a dictionary with

    - "events": (n,) events of `EVENT_DTYPE`; or (bins, height, width) float32, a voxel grid; or
      (2, rows, columns) float32, the paper's averaged time surfaces, OFF and ON (equations 2 to 8);
    - "t_us", the time of the label [µs], and "sequence", such as "train/0000";
    - the labels that were asked for: "flow" and "flow_backward", (2, height, width) float32 [px],
      with "flow_valid" and "flow_backward_valid"; "velocity", (2, height, width) float32 [px/s];
      "depth", (height, width) float32 [m]; "masks", (height, width) uint8; "images", (3, height,
      width) uint8; "boxes", (n,) of `TRACK_DTYPE`; and for "motion" the target's "direction" (0 to
      3: right, left, up, down), "angular_velocity_rad_s", "image_velocity_px_s" and "visibility".

    Every process opens files of its own, so that workers of a DataLoader do not disturb each other.
    """

    def __init__(
        self,
        root: Path | str,
        split: str | None = None,
        *,
        window_us: int | None = None,
        count: int | None = None,
        after: bool = False,
        representation: Representation | str = Representation.EVENTS,
        bins: int = BINS,
        labels: Sequence[str] = (),
        transform: Callable[[Events], Any] | None = None,
    ) -> None:
        """List the samples.

        Args:
            root: folder that `flybench dataset` wrote.
            split: name of a split; None: all splits.
            window_us: length of a slice [µs]; for time surfaces, leave it out: it is the fly's.
            count: number of events of a slice, instead of `window_us`.
            after: False: slices end at the label; True: they start there, as the events of flow do.
            representation: form of the events.
            bins: number of bins of voxel grids.
            labels: labels of the samples, of `READABLE`.
            transform: function of the events of a slice, such as one of tonic, in place of another
                representation.

        Raises:
            ScenarioError: the folder holds no dataset, no such split or no such label; or the
                arguments do not fit together.
        """
        self._root, self._transform, self._bins = Path(root).absolute(), transform, bins
        self._form, self._fly = _checked_form(representation, transform, bins), FlyConfig()
        self._slicing = _slicing(self._form, self._fly, window_us, count, after=after)
        dataset = _read_json(self._root / SUMMARY, self._root)
        self._labels = tuple(labels)
        _check_labels(self._labels, dataset["labels"])
        self._sequences: list[tuple[str, SequenceLabels]] = []
        self._samples: list[tuple[int, int, int, int]] = []
        self._files: dict[str, Any] = {}
        self._process, self._inherited = os.getpid(), [self._files]
        for name in _split_names(split, dataset["splits"]):
            for folder in sorted((self._root / name).iterdir()):
                self._add(f"{name}/{folder.name}", folder)

    def __len__(self) -> int:
        return len(self._samples)

    def __getitem__(self, index: int) -> dict[str, Any]:
        """Return a sample; see the class."""
        sequence, number, start, end = self._samples[index]
        name, labels = self._sequences[sequence]
        file = self._open(name)
        events, t_us = read_events(file, start, end), labels.times_us[number]
        size = {"width": int(file.attrs["width"]), "height": int(file.attrs["height"])}
        sample = {"events": self._formed(events, t_us, size), "t_us": t_us, "sequence": name}
        for label in self._labels:
            sample |= labels.read(label, number)
        return sample

    def __getstate__(self) -> dict[str, Any]:
        """Leave open files out of a copy for another process."""
        return self.__dict__ | {"_files": {}, "_inherited": []}

    def _add(self, name: str, folder: Path) -> None:
        """Add the samples of a sequence."""
        facts = _read_json(folder / SUMMARY, self._root)
        times = label_times_us(facts["duration_us"], facts["period_us"])
        self._sequences.append((name, SequenceLabels(folder, times)))
        wanted = [READABLE[label] for label in self._labels]
        first = max((label.first for label in wanted), default=0)
        last = min((label.last for label in wanted), default=-1)
        with h5py.File(folder / EVENTS) as file:
            for number in range(first, len(times) + last + 1):
                bounds = self._slicing.bounds(file, times[number])
                if bounds is not None:
                    self._samples.append((len(self._sequences) - 1, number, *bounds))

    def _open(self, name: str) -> Any:
        """Return the open events of a sequence, opened by this process."""
        if os.getpid() != self._process:
            # A forked process must not close what it has inherited, so it keeps a reference.
            self._inherited.append(self._files)
            self._files, self._process = {}, os.getpid()
        if name not in self._files:
            while len(self._files) >= _OPEN_FILES:
                self._files.pop(next(iter(self._files))).close()
            self._files[name] = h5py.File(self._root / name / EVENTS)
        return self._files[name]

    def _formed(self, events: Events, label_us: int, size: dict[str, int]) -> Any:
        if self._transform is not None:
            return self._transform(events)
        if self._form is Representation.EVENTS:
            return events
        if self._form is Representation.TIME_SURFACE:
            return self._time_surfaces(events, self._slicing.window(label_us)[0], size)
        if self._slicing.count is None:
            start_us, end_us = self._slicing.window(label_us)
        else:
            start_us, end_us = int(events["t"][0]), int(events["t"][-1]) + 1
        return voxel_grid(events, start_us=start_us, end_us=end_us, bins=self._bins, **size)

    def _time_surfaces(
        self, events: Events, start_us: int, size: dict[str, int]
    ) -> npt.NDArray[np.float32]:
        """Return the averaged surfaces of a window, whose events remember the window before it."""
        c, taken = self._fly, 0
        surfaces, first_us = TimeSurfaces(c, **size), start_us - c.window_us
        shifted = events.copy()
        shifted["t"] -= first_us
        for hop in range(2 * c.window_hops):
            surfaces.begin_hop(hop)
            taken = surfaces.accumulate(shifted, taken, until_us=(hop + 1) * c.hop_us)
        return surfaces.average(hop=2 * c.window_hops - 1)


def _checked_form(
    value: Representation | str, transform: Callable[[Events], Any] | None, bins: int
) -> Representation:
    if value not in list(Representation):
        raise ScenarioError(
            f"representation is {value!r}. Allowed is one of {', '.join(Representation)}. Choose "
            "one of them, or pass a transform."
        )
    if transform is not None and value != Representation.EVENTS:
        raise ScenarioError(
            f"representation is {value!r} and a transform is given. Allowed is one of them. Leave "
            "the other out."
        )
    if bins < 1:
        raise ScenarioError(f"bins is {bins!r}. Allowed is 1 or more. The default is {BINS}.")
    return Representation(value)


def _slicing(
    form: Representation, fly: FlyConfig, window_us: int | None, count: int | None, *, after: bool
) -> Slicing:
    if form is not Representation.TIME_SURFACE:
        return Slicing(window_us, count, after)
    if count is not None or window_us not in (None, fly.window_us):
        raise ScenarioError(
            f"window_us is {window_us!r} and count is {count!r} for time surfaces. Their window is "
            f"that of the fly, {fly.window_us} µs. Leave both out."
        )
    return Slicing(fly.window_us, None, after, history_us=fly.window_us)


def _check_labels(wanted: Sequence[str], available: Sequence[str]) -> None:
    known = [name for name, label in READABLE.items() if label.label in available]
    for name in wanted:
        if name not in known:
            raise ScenarioError(
                f"labels holds {name!r}. Allowed for this dataset is "
                f"{', '.join(known) or 'nothing'}. Correct the name, or make the dataset with this "
                "label."
            )


def _split_names(split: str | None, splits: dict[str, int]) -> list[str]:
    if split is not None and split not in splits:
        raise ScenarioError(
            f"split is {split!r}. Allowed for this dataset is one of {', '.join(splits)}. Leave it "
            "out for all of them."
        )
    return list(splits) if split is None else [split]


def _read_json(path: Path, root: Path) -> dict[str, Any]:
    try:
        summary = json.loads(read_small_text(path))
    except (OSError, ValueError, RecursionError):
        summary = None
    is_own = isinstance(summary, dict) and summary.get("generator") == GENERATOR
    if not is_own or summary.get("command") != "dataset":
        raise ScenarioError(
            f"{root} holds no complete dataset: {path} is missing or not of a dataset. Allowed is "
            "a folder that `flybench dataset` has finished. Give that folder, or finish it with "
            "the same command."
        )
    return dict(summary)
