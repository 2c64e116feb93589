"""Print how often the fly gives a direction in flickering light: `python -m tools.flicker_table`.

A still, blurred texture of 20 to 180 cd/m² flickers during half a second. Each cell is the share of
steps that give a direction with `share_floor`, and in brackets without it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from typing import get_args

import cv2
import numpy as np
import numpy.typing as npt

from detector.fly.detector import FlyConfig, FlyDetector
from emulator import EventSensor, Lines, ReadoutConfig, ReadoutKind, SensorConfig, preset
from emulator.presets import PresetName
from flybench.direction import Direction
from flybench.events import Events

DEPTHS, FREQUENCIES_HZ, PRESETS = (0.1, 0.2, 0.4), (100, 120), ("paper", "wide")
DURATION_US, STEP_US = 500_000, 1_000
IN_TURN = ReadoutConfig(kind=ReadoutKind.ROUND_ROBIN, lines=Lines.ROWS, line_words=1)


def texture() -> npt.NDArray[np.float32]:
    """Return the luminance of the texture, (260, 346) [cd/m²]."""
    noise = np.random.default_rng(0).random((260, 346)).astype(np.float32)
    blurred = cv2.GaussianBlur(noise, (0, 0), 2.0)
    return np.asarray(200 * (0.1 + 0.8 * (blurred - blurred.min()) / np.ptp(blurred)), np.float32)


def flickering(config: SensorConfig, *, depth: float, frequency_hz: float) -> Iterator[Events]:
    """Yield the events of each step of a sensor that sees the flickering texture."""
    luminance, sensor = texture(), EventSensor(config, seed=1)
    for t_us in range(0, DURATION_US + 1, STEP_US):
        gain = 1 + depth * np.sin(2 * np.pi * frequency_hz * t_us * 1e-6)
        yield sensor.step(t_us, (luminance * gain).astype(np.float32)).events


def shares(config: SensorConfig, *, depth: float, frequency_hz: float) -> dict[str, list[float]]:
    """Return the shares with and without `share_floor` of each preset of the fly [%]."""
    flies = {
        name: [FlyDetector(fly), FlyDetector(replace(fly, share_floor=0.0))]
        for name in PRESETS
        for fly in [FlyConfig.preset(name)]
    }
    given: dict[str, list[list[bool]]] = {name: [[], []] for name in PRESETS}
    for events in flickering(config, depth=depth, frequency_hz=frequency_hz):
        for name, pair in flies.items():
            for fly, found in zip(pair, given[name], strict=True):
                found += [e.direction is not Direction.NONE for e in fly.push(events)]
    for name, pair in flies.items():
        for fly, found in zip(pair, given[name], strict=True):
            found += [e.direction is not Direction.NONE for e in fly.advance(DURATION_US)]
    return {name: [100 * float(np.mean(x)) for x in found] for name, found in given.items()}


def main() -> None:
    """Print the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--preset", choices=get_args(PresetName), default="davis346")
    parser.add_argument("--in-turn", action="store_true", help="read the rows in their order")
    options = parser.parse_args()
    config = preset(options.preset)
    if options.in_turn:
        config = replace(config, readout=IN_TURN)
    heads = [f"{name}, {hz} Hz" for name in PRESETS for hz in FREQUENCIES_HZ]
    print("| depth of the flicker |", " | ".join(heads), "|")
    print("| --- |" + " --- |" * len(heads))
    for depth in DEPTHS:
        found = [shares(config, depth=depth, frequency_hz=hz) for hz in FREQUENCIES_HZ]
        cells = [f"{of[name][0]:.0f} % ({of[name][1]:.0f})" for name in PRESETS for of in found]
        print(f"| {depth:g} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
