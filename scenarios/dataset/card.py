"""The card of a dataset: a README.md as public hubs expect it."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from scenarios.dataset.draws import Draws
from scenarios.dataset.labels.kinds import CONTENTS
from scenarios.dataset.plan import DatasetPlan
from scenarios.dataset.sequence_plan import code_digest
from scenarios.output.numbers import counted
from scenarios.output.versions import versions
from scenarios.sweep.random_sample import Distribution

Summaries = Sequence[Mapping[str, Any]]
_SIZES = ((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"), (10**9, "100K<n<1M"))

_LAYOUT = """\
Each sequence is a folder with the layout of [DSEC](https://dsec.ifi.uzh.ch/data-format/):

| file | contents |
| --- | --- |
| `events/left/events.h5` | events: `events/t` [µs], `events/x`, `events/y` [px], `events/p` (1 is ON), `ms_to_idx`, `t_offset` |
| `events/left/rectify_map.h5` | identity: the lens has no distortion |
| `events/left/event_labels.h5` | `source` (number of the object; −1 background, −2 noise), `cause` (0 signal, 1 leak, 2 shot noise, 3 hot pixel), `flow_px_s` (NaN for noise) |
| `images/timestamps.txt` | times of the labels [µs]; label n has the name `00000n.png` |
| `images/left/distorted/` | preview, in colour for streets |
| `flow/forward/`, `flow/backward/` | displacement to the next and to the previous label: (code − 2¹⁵) / 128 px in the first two channels, 1 in the third where valid; their times in `flow/*_timestamps.txt` |
| `flow/velocity.h5` | `velocity_px_s` (labels, height, width, 2) |
| `depth/` | depth along the optical axis: code / 256 m; 0 for the sky |
| `masks/` | 1 + number of the object; 0 for the background |
| `object_detections/left/tracks.npy` | boxes in the layout of [DSEC-Detection](https://github.com/uzh-rpg/dsec-det) |
| `object_detections/left/coco.json` | the same as COCO, with masks; `annotations_SPLIT.json` joins them. Bodies of a model have classes of their own: 8 + their number in `tracks.npy`, 101 + it in COCO |
| `motion.csv` | direction, angular velocity, image velocity, distance and visibility of every object |
| `calibration/cam_to_cam.yaml`, `poses.csv` | intrinsics; position and rotation of the camera every millisecond |
| `shard.tar` | one sample for each label but the last, for WebDataset: the events until the next label (`events.npy`), the images and boxes (`boxes.json`) of the label, and `json` |
| `aps/` | frames of the sensor, 10 bits, with `exposure_timestamps.txt` |
| `summary.json` | every parameter, the objects by number, counts, versions, checksums |

`sequences.csv` has one row for each sequence, with every parameter. `sha256sum -c checksums.sha256`
checks all files. Flow and depth are exact for what the middle of each pixel shows.
"""  # noqa: E501


def card_text(plan: DatasetPlan, summaries: Summaries) -> str:
    """Return the card as Markdown, with metadata for hubs at its top.

    Args:
        plan: the dataset.
        summaries: summary of each sequence.
    """
    spec = plan.spec
    parts = [
        _metadata(plan),
        f"# {spec.title}\n",
        f"A synthetic dataset of an event camera: {counted(len(summaries), 'sequence')} in "
        f"which {_scene(plan)}, with exact labels. It was rendered and emulated by flybench "
        f"{versions()['flybench']}; no real recording is part of it.\n",
        "![One sequence of each split, and the statistics](overview.png)\n",
        "## Splits\n",
        "\n".join(_split_table(plan, summaries)) + "\n",
        "## Labels\n",
        "\n".join(f"- `{label}`: {CONTENTS[label]}" for label in spec.labels) + "\n",
        f"Labels are {spec.period_us / 1000:g} ms apart.\n",
        "## Files\n",
        _LAYOUT,
        "## What was drawn\n",
        "\n".join(_range_table(plan)) + "\n",
        _disjoint_text(plan),
        "Parameters that are not in the table have flybench's defaults; every value is in "
        "`sequences.csv`.\n",
        "## How it was made\n",
        f"`flybench dataset dataset.toml` with seed {spec.seed}; the seed of each sensor is in "
        f"`sequences.csv`. Digest of the code: `{code_digest()[:16]}`.\n",
        "\n".join(f"- {name} {number}" for name, number in versions().items()) + "\n",
        f"## Licence\n\n{spec.license}\n",
    ]
    return "\n".join(parts)


def _scene(plan: DatasetPlan) -> str:
    return "a MuJoCo model moves" if plan.spec.is_model else "a vehicle crosses a street"


def _metadata(plan: DatasetPlan) -> str:
    spec, count = plan.spec, len(plan.sequences)
    size = next(name for limit, name in _SIZES if count < limit)
    lines = [
        "---",
        f"license: {json.dumps(spec.license.lower())}",
        f"pretty_name: {json.dumps(spec.title)}",
        f"size_categories: [{json.dumps(size)}]",
        "tags: [event-camera, synthetic, optical-flow, object-detection, motion-detection]",
        "---",
        "",
    ]
    return "\n".join(lines)


def _split_table(plan: DatasetPlan, summaries: Summaries) -> Iterator[str]:
    yield "| split | sequences | seconds | events | noise | labels | boxes | directions |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- |"
    for split in plan.spec.counts:
        own = [s for s in summaries if s["split"] == split]
        events = sum(s["events"]["count"] for s in own)
        signal = sum(s["events"]["by_cause"]["signal"] for s in own)
        noise = f"{100 * (events - signal) / events:.1f} %" if events else "–"
        cells = [
            split,
            str(len(own)),
            f"{sum(s['duration_us'] for s in own) / 1e6:.1f}",
            f"{events:,}",
            noise,
            f"{sum(s['label_times'] for s in own):,}",
            _counts(sum((Counter(s["boxes"]) for s in own), Counter())),
            _counts(Counter(s["direction"] for s in own if s["direction"])),
        ]
        yield f"| {' | '.join(cells)} |"


def _counts(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{name} {number:,}" for name, number in sorted(counts.items())) or "–"


def _range_table(plan: DatasetPlan) -> Iterator[str]:
    """Yield one row for each parameter: its value or range, in all splits or in each."""
    yield "| parameter | split or variant | value |"
    yield "| --- | --- | --- |"
    by_split = [(split, _entries(draws)) for split, draws in plan.ranges.items()]
    for name in by_split[0][1]:
        texts = {split: entries[name] for split, entries in by_split}
        if len(set(texts.values())) == 1:
            yield f"| `{name}` | all | {by_split[0][1][name]} |"
        else:
            yield from (f"| `{name}` | {split} | {text} |" for split, text in texts.items())
    for variant, draws in plan.spec.variants.items():
        yield from (f"| `{name}` | {variant} | {text} |" for name, text in _entries(draws).items())


def _entries(draws: Draws) -> dict[str, str]:
    fixed = {name: str(value) for name, value in draws.fixed.items()}
    return fixed | {d.name: _range_text(d) for d in draws.drawn}


def _range_text(distribution: Distribution) -> str:
    values = [f"{v:.6g}" if isinstance(v, float) else str(v) for v in distribution.values]
    if distribution.kind == "choice":
        return f"one of {', '.join(values)}"
    between = f"{values[0]} to {values[1]}"
    return between if distribution.kind == "uniform" else f"{between}, log-uniform"


def _disjoint_text(plan: DatasetPlan) -> str:
    names = plan.spec.disjoint
    if not names:
        return "Splits may share values of all parameters.\n"
    return f"No two splits share a value of: {', '.join(names)}.\n"
