"""Print how well events converge in 65 combinations: `python -m tools.convergence_table`.

A combination is a time of day with a vehicle and a direction, or with a distractor. 2.5 px of
motion (2.4 px of a draft, in whole steps) are compared with a reference of 6×6 sub-pixels every
0.25 px. It takes about 40 minutes of CPU; `--group` measures a part.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from flybench.direction import Direction
from scenarios.convergence.matching import WITHIN_US, Match, match
from scenarios.convergence.measure import (
    Rendering,
    events_of,
    piece_events,
    piece_times_us,
    with_keyframe_times_us,
)
from sim import (
    Crossing,
    CrossingConfig,
    Distractors,
    Lighting,
    Quality,
    RelativeDirection,
    VehicleKind,
)
from sim.cache.luminance_file import LuminanceSample
from sim.distractors import Pavement
from sim.geometry.rectangles import image_rectangle
from sim.keyframes.midpoints import with_midpoints
from sim.render.filament import Luminance

PIECE_PX = 2.5
REFERENCE = Rendering("full", 6, 0.25)
OF_CONFIG = CrossingConfig()
DEFAULT = Rendering("keyframes", OF_CONFIG.supersample, OF_CONFIG.step_px, OF_CONFIG.keyframe_px)
FULL = Rendering("full", 2, OF_CONFIG.step_px)
OMEGA_RAD_S = {Lighting.DAY: 1.61, Lighting.DUSK: 1.61, Lighting.NIGHT: 1.42}
SHAKE_RMS_DEG, WIND_GRADE, FLICKER_HZ = 0.1, 5, 100
SAME, OPPOSITE = RelativeDirection.SAME, RelativeDirection.OPPOSITE
DISTRACTORS = (
    Distractors(wind_grade=WIND_GRADE),
    Distractors(far_vehicle=SAME),
    Distractors(far_vehicle=OPPOSITE),
    Distractors(far_vehicle=OPPOSITE, far_vehicle_kind=VehicleKind.VAN),
    Distractors(pedestrian=SAME),
    Distractors(pedestrian=OPPOSITE),
    Distractors(pedestrian=OPPOSITE, pedestrian_pavement=Pavement.NEAR),
)
LAMPS_FLICKER = Distractors(flicker_hz=FLICKER_HZ)
SHAKE = Distractors(shake_rms_deg=SHAKE_RMS_DEG)
ALL = replace(SHAKE, wind_grade=WIND_GRADE, far_vehicle=OPPOSITE, pedestrian=SAME)
NAMES = ("full 2×2", "draft", "default", "fine")
DIRECTIONS = (Direction.RIGHT, Direction.LEFT, Direction.UP, Direction.DOWN)
GROUPS = (*Lighting, "distractors", "shake", "all")


def combinations(group: str) -> Iterator[CrossingConfig]:
    """Yield the crossings of a group."""
    for lighting in Lighting:
        plain = CrossingConfig(lighting=lighting, omega_rad_s=OMEGA_RAD_S[lighting])
        has_lamps = lighting is not Lighting.DAY
        if group == lighting:
            for vehicle in VehicleKind:
                for direction in DIRECTIONS:
                    yield replace(plain, vehicle=vehicle, direction=direction)
        elif group == "distractors":
            for distractors in (*DISTRACTORS, *[LAMPS_FLICKER] * has_lamps):
                yield replace(plain, distractors=distractors)
        elif group == "shake":
            yield replace(plain, distractors=SHAKE)
        elif group == "all":
            flicker_hz = FLICKER_HZ if has_lamps else 0
            yield replace(plain, distractors=replace(ALL, flicker_hz=flicker_hz))


def frames_with_midpoints(config: CrossingConfig) -> list[tuple[int, Luminance]]:
    """Return the samples of a draft or of fine quality, with those that it puts in between."""
    crossing = Crossing(replace(config, quality=Quality.FULL, keyframe_px=config.drawn_keyframe_px))
    times_us = piece_times_us(crossing, PIECE_PX, config.drawn_step_px)
    around_us = [2 * times_us[0] - times_us[1], *times_us, 2 * times_us[-1] - times_us[-2]]
    changed = image_rectangle(crossing.intrinsics)
    with crossing.keyframe_renderer(with_keyframe_times_us(crossing, around_us)) as render:
        rendered = [(t_us, render(t_us)) for t_us in around_us]
    samples = [LuminanceSample(t_us, s.luminance, s.body, changed) for t_us, s in rendered]
    first_us, last_us = times_us[0], times_us[-1]
    return [
        (sample.t_us, sample.luminance)
        for sample in with_midpoints(samples)
        if first_us <= sample.t_us <= last_us
    ]


def measured(config: CrossingConfig) -> list[Match]:
    """Return how well each rendering of `NAMES` agrees with the reference."""
    reference, full, default = (
        piece_events(config, PIECE_PX, rendering)[0] for rendering in (REFERENCE, FULL, DEFAULT)
    )
    draft, fine = (
        frames_with_midpoints(replace(config, quality=quality))
        for quality in (Quality.DRAFT, Quality.FINE)
    )
    return [
        match(full, reference),
        match(events_of(draft), reference[reference["t"] <= draft[-1][0]]),
        match(default, reference),
        match(events_of(fine), reference),
    ]


def share(found: Match, limit: int) -> float:
    """Return the smaller of recall and precision at a limit of `WITHIN_US`."""
    return min(found.recall[limit], found.precision[limit])


def cells(found: Iterable[Match]) -> str:
    """Return the spans of excess, shares within 0.2 and 2 ms, and median, as cells of a table."""
    columns = {
        "+.1f": [100 * m.excess for m in found],
        ".0f": [100 * share(m, 0) for m in found],
        ".1f": [100 * share(m, len(WITHIN_US) - 1) for m in found],
        "0.0f": [m.median_us for m in found],
    }
    return " | ".join(f"{min(c):{f}} to {max(c):{f}}" for f, c in columns.items())


def excess_rms(found: Iterable[Match]) -> float:
    """Return the root mean square error of the number of events [%]."""
    return 100 * math.sqrt(np.mean([m.excess**2 for m in found]))


def print_comparisons(found: list[list[Match]]) -> None:
    """Print in how many combinations one rendering is worse than another."""
    full, _, default, fine = zip(*found, strict=True)
    pairs = {"default, full 2×2": (default, full), "fine, full 2×2": (fine, full)}
    for names, (ours, theirs) in (pairs | {"fine, default": (fine, default)}).items():
        both = list(zip(ours, theirs, strict=True))
        fewer = sum(any(share(a, k) < share(b, k) for k in range(len(WITHIN_US))) for a, b in both)
        later = sum(a.median_us > b.median_us for a, b in both)
        worse = sum(abs(a.excess) > abs(b.excess) for a, b in both)
        gains = [100 * (share(a, 0) - share(b, 0)) for a, b in both]
        ratios = [a.median_us / b.median_us for a, b in both]
        print(
            f"{names}: of {len(both)}, a lower share in {fewer}, a larger median in {later}, a "
            f"larger error of the number in {worse}; {min(gains):+.1f} to {max(gains):+.1f} "
            f"points in 0.2 ms; median {min(ratios):.2f} to {max(ratios):.2f} times"
        )


def main() -> None:
    """Print the table as Markdown, and what compares the renderings."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--group", choices=GROUPS, action="append", help="default: all groups")
    groups = parser.parse_args().group or GROUPS
    print("| | | events [%] | matched in 0.2 ms [%] | in 2 ms [%] | median [µs] |")
    print("| --- | --- | --- | --- | --- | --- |")
    everything, without_shake = [], []
    for group in groups:
        found = []
        for number, config in enumerate(combinations(group), 1):
            print(f"{group} {number}", file=sys.stderr, flush=True)
            found.append(measured(config))
            if config.distractors.shake_rms_deg == 0:
                without_shake.append(found[-1])
        for name, each in zip(NAMES, zip(*found, strict=True), strict=True):
            print(f"| {group} | {name} | {cells(each)} |", flush=True)
        everything += found
    for where, found in (("all", everything), ("without shake", without_shake)):
        rms = [excess_rms(each) for each in zip(*found, strict=True)]
        print(f"error of the number of events, {where}:", end=" ")
        print(", ".join(f"{name} {value:.2f} %" for name, value in zip(NAMES, rms, strict=False)))
    print_comparisons(everything)


if __name__ == "__main__":
    main()
