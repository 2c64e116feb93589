"""Recordings that the tests make, and manifests that list them."""

import hashlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from emulator import ApsFrame
from flybench.events import Events
from formats import open_writer
from tests.detector.stimuli import asphalt, hot_pixels, merged, noise, slide, textured_box

WIDTH, HEIGHT = 346, 260
START_US = 5_000_000
"""Time of the first event of the recordings [µs]."""


@lru_cache(maxsize=1)
def rightward() -> Events:
    """Return 0.3 s of a box that moves right at 400 px/s; the first event is at time 0."""
    events = slide(
        textured_box(),
        speed_px_s=400.0,
        start_px=60.0,
        top_px=100,
        duration_us=300_000,
        background=asphalt(HEIGHT, WIDTH),
    )
    events["t"] -= events["t"][0]
    return events


@lru_cache(maxsize=1)
def still() -> Events:
    """Return 0.3 s of noise."""
    return merged(noise(2.0, duration_us=300_000), hot_pixels(5, 50.0, duration_us=300_000))


def write_recording(path: Path, events: Events, frames: int = 0) -> str:
    """Write events, and frames that rise in brightness; return the SHA-256 of the file."""
    late = events.copy()
    late["t"] += START_US
    with open_writer(path, width=WIDTH, height=HEIGHT) as writer:
        writer.write(late)
        for k in range(frames):
            start_us = START_US + 50_000 * k + 10_000
            image = np.full((HEIGHT, WIDTH), 100 * k, np.uint16)
            writer.write_frame(ApsFrame(start_us, start_us + 5000, image))
    return hashlib.sha256(path.read_bytes()).hexdigest()


def entry(name: str, file: str, sha256: str, **more: Any) -> dict[str, Any]:
    """Return the keys of a recording without its windows."""
    facts = {"licence": "CC0", "source": "made by a test"}
    return {"name": name, "file": file, "sha256": sha256, **facts, **more}


def write_manifest(path: Path, *recordings: tuple[Mapping[str, Any], list[Any]]) -> Path:
    """Write a manifest of recordings and their windows, and return its path."""
    lines = []
    for keys, windows in recordings:
        lines += ["[[recording]]", *_lines(keys)]
        for window in windows:
            lines += ["[[recording.window]]", *_lines(window)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _lines(keys: Mapping[str, Any]) -> list[str]:
    text = {True: "true", False: "false"}
    return [
        f"{k} = {text[v] if isinstance(v, bool) else repr(v)}" for k, v in keys.items()
    ]  # TOML takes Python's strings, numbers and lists
