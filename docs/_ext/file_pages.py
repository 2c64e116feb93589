"""Pages of the columns of every CSV file and of the entities of a recording, from the code.

A column without a meaning here, or a meaning without a column, stops the build.
"""

import dataclasses
import re
from collections.abc import Sequence
from typing import Any

import docstring_parser
from configuration_pages import as_cell

from scenarios.convergence.measure import COLUMNS as CONVERGENCE
from scenarios.dataset.labels.camera import POSE_COLUMNS
from scenarios.dataset.labels.motion import COLUMNS as MOTION
from scenarios.envelope.stimulus import Stimulus
from scenarios.output.tables import ESTIMATE_COLUMNS, TRUTH_COLUMNS
from scenarios.recording import entities
from scenarios.study.rows import COLUMNS as STUDY
from scenarios.validate.results import COLUMNS as VALIDATE

SCORES = {
    "verdict": "direction that the method finds over the whole crossing",
    "accuracy": "share of the steps in view with the correct direction",
    "accuracy_after_100ms": "the same share over the steps from 100 ms in view on",
    "opposite_after_100ms": "share of these steps with the opposite direction",
    "sideways_after_100ms": "share of these steps with a direction along the other axis",
    "none_after_100ms": "share of these steps without a direction",
    "steps_in_view": "number of steps in view; a step is one estimate",
    "latency_ms": "time from the first visible pixel to the first correct step [ms]; empty if "
    "there is none, or if the target is in view from the start",
    "roi_iou": "mean overlap of the region of interest with the target's box, over the steps after "
    "100 ms; empty for a method without a region",
    "centroid_error_px": "mean distance from the view centre to the target's centroid [px]",
    "grms": "gradient root mean square of the response [1/s]; see `detector.metrics.grms`",
}
SHARED = {
    "t_us": "time since the start of the sequence [µs]",
    "lighting": "day, dusk or night",
    "method": "name of the method, as for `--method`",
    "seed": "seed of the sensor",
    "failed": "why the detector failed; empty if it did not",
}
MEANING: dict[str, dict[str, str]] = {
    "truth.csv": {
        "t_us": SHARED["t_us"],
        "direction": "true direction of the target in the image",
        "angular_velocity_rad_s": "angular velocity of the target about the camera [rad/s]",
        "image_velocity_x_px_s": "image velocity of the target, positive to the right [px/s]",
        "image_velocity_y_px_s": "image velocity of the target, positive downwards [px/s]",
        "position_m": "distance of its middle past the point of closest approach [m]",
        "visibility": "share of its silhouette that is in the image and not hidden, 0 to 1",
        "box_x0_px": "left edge of the box [px]; boxes are half-open and empty when out of view",
        "box_y0_px": "upper edge [px]",
        "box_x1_px": "right edge, exclusive [px]",
        "box_y1_px": "lower edge, exclusive [px]",
        "centroid_x_px": "centroid of the visible pixels [px]",
        "centroid_y_px": "centroid of the visible pixels [px]",
    },
    "estimates.csv": {
        "t_us": "time of the estimate [µs]",
        "hs": "response of the horizontal system, −1 to 1, positive to the right",
        "vs": "response of the vertical system, −1 to 1, positive downwards",
        "direction": "right, left, up, down or none",
        "strength": "magnitude of the stronger response, 0 to 1",
        "response_hs": "horizontal response before normalisation; for methods that measure "
        "velocity, the image velocity [px/s]",
        "response_vs": "vertical response before normalisation",
    },
    "results.csv of a study": {
        "sequence": "name of the sequence, and of its recording",
        "lighting": SHARED["lighting"],
        "background": "what moves besides the target: still, wind, vehicle, shake or all",
        "sensor": "default, or high thresholds",
        "omega_rad_s": "angular velocity at closest approach [rad/s]",
        "speed_km_h": "speed of the vehicle [km/h]",
        "image_speed_px_s": "image speed at closest approach [px/s]",
        "duration_s": "duration of the sequence [s]",
        "truth": "true direction",
        "method": SHARED["method"],
        "seed": SHARED["seed"],
        **SCORES,
        "response_mean": "mean response along the true direction, over the steps after 100 ms",
        "response_variation": "its standard deviation over its mean; empty if that is not above 0",
        "velocity_error_px_s": "root mean square error of the image velocity [px/s]",
        "velocity_bias_px_s": "mean error of the image velocity along the true motion [px/s]",
        "cpu_s": "CPU time of all calls of the detector [s]",
        "ms_per_estimate": "CPU time per estimate [ms]",
        "ns_per_event": "CPU time per event [ns]",
        "events": "number of events given to the method",
        "estimates": "number of estimates",
    },
    "results.csv of a validation": {
        "recording": "name of the recording",
        "window": "number of the window, from 1",
        "from_s": "start of the window after the first event [s]",
        "to_s": "end of the window [s]",
        "crop": "part of the sensor that was used [px]",
        "variant": "as recorded, mirrored, or turned by 90°, 180° or 270°",
        "truth": "true direction in this variant",
        "method": SHARED["method"],
        "steps": "number of steps",
        "right": "steps with the true direction",
        "wrong": "steps with another direction where something moves",
        "none": "steps without a direction where something moves",
        "first_right_ms": "end of the first right step after the start of the window [ms]",
        "false_alarms": "steps with a direction where nothing moves",
        "verdict": "verdict as of `flybench detect`",
        "note": "what limits the result, such as a window that is too short to judge",
        "failed": SHARED["failed"],
    },
    "convergence.csv": {
        "lighting": SHARED["lighting"],
        "rendering": "full, or keyframes",
        "supersampling": "sub-pixels per pixel along each axis",
        "step_px": "largest motion between two samples [px]",
        "keyframe_px": "motion from one keyframe to the next [px]",
        "cpu_ms_per_sample": "CPU time of a sample [ms]",
        "events_excess": "events more than those of the reference, as a share of these",
        "recall_within_…us": "share of the reference's events that are matched within this time",
        "precision_within_…us": "share of the events that the reference has within this time",
        "median_us": "median difference in time of matched events [µs]",
    },
    "motion.csv of a dataset": {
        "t_us": SHARED["t_us"],
        "track_id": "number of the object",
        "name": "name of the object; the vehicle that crosses is `target`",
        "kind": "sedan, van, motorcycle, pedestrian or tree",
        "direction": "true direction; only of the target",
        "angular_velocity_rad_s": "angular velocity about the camera [rad/s]",
        "image_velocity_x_px_s": "image velocity, positive to the right [px/s]",
        "image_velocity_y_px_s": "image velocity, positive downwards [px/s]",
        "reference_x_px": "point to which the velocity refers [px]",
        "reference_y_px": "point to which the velocity refers [px]",
        "distance_m": "distance from the camera [m]",
        "visibility": "share of the silhouette that is in the image and not hidden, 0 to 1",
    },
    "poses.csv of a dataset": {
        "t_us": SHARED["t_us"],
        "x_m": "position of the camera along the road [m]",
        "y_m": "position across the road [m]",
        "z_m": "height [m]",
        "qx": "rotation from the camera's axes to the world's, a unit quaternion",
        "qy": "rotation",
        "qz": "rotation",
        "qw": "rotation, the real part",
    },
}
COLUMNS: dict[str, Sequence[str]] = {
    "truth.csv": TRUTH_COLUMNS,
    "estimates.csv": ESTIMATE_COLUMNS,
    "results.csv of a study": STUDY,
    "results.csv of a validation": VALIDATE,
    "convergence.csv": ("lighting", *CONVERGENCE),
    "motion.csv of a dataset": MOTION,
    "poses.csv of a dataset": POSE_COLUMNS,
}
INTRO = """\
# Columns of the tables

Every table is CSV in UTF-8 with one header row. An empty cell means that there is no value. The
last part of a name is its unit.
"""
ENVELOPE = """\
## envelope.csv

One row for each stimulus and method: `method`, the parameters of the stimulus, the scores as in the
table of a study (`verdict` to `grms`), `events`, and `detector_cpu_s`, the CPU time of the detector
[s].
"""
OTHERS = """\
## results.csv of a sweep

One row for each point, also as `results.parquet`. The columns are the labels, every parameter by
its dotted name (`flybench sweep --parameters` lists them), and `truth.*`, `events.*` and
`detector.*` as in the `summary.json` of a run. Rows are in the order of the file.

## velocities.csv

One row for each velocity, lighting and seed: the parameters, the truth and the scores.

## filters.csv, roc.csv and steps.csv of `denoise`

`lighting`, `illuminance_lux`, `events` and `noise_share` (the share of noise among the events) say
what was filtered. Then come `filter`, `auc` (area under the ROC curve), `kept_signal` and
`kept_noise` (shares at the filter's default) and `cpu_ns_per_event`. `roc.csv` has the points of
the curves. `steps.csv` has the scores of each method behind each filter.
"""


def file_pages() -> dict[str, str]:
    """Return the text of each page by its file name."""
    tables = [_table(name, columns) for name, columns in COLUMNS.items()]
    return {
        "columns.md": "\n".join([INTRO, *tables, ENVELOPE, _stimulus(), OTHERS]),
        "entities.md": _entities(),
    }


def _table(name: str, columns: Sequence[str]) -> str:
    short = dict.fromkeys(re.sub(r"within_\d+us", "within_…us", column) for column in columns)
    meaning = MEANING[name]
    wrong = sorted(set(short) ^ set(meaning))
    if wrong:
        raise ValueError(f"docs/_ext/file_pages.py and the columns of {name} differ: {wrong}.")
    rows = [f"| `{column}` | {meaning[column]} |" for column in short]
    return "\n".join([f"## {name}\n", "| column | meaning |", "| --- | --- |", *rows, ""])


def _stimulus() -> str:
    meaning = _attributes(Stimulus)
    rows = [f"| `{f.name}` | {as_cell(meaning[f.name])} |" for f in dataclasses.fields(Stimulus)]
    return "\n".join(["| parameter | meaning |", "| --- | --- |", *rows, ""])


def _attributes(kind: type) -> dict[str, str]:
    parsed = docstring_parser.parse(kind.__doc__ or "", docstring_parser.DocstringStyle.GOOGLE)
    return {p.arg_name: p.description or "" for p in parsed.params}


def _entities() -> str:
    """Return the list of entity paths: the constants, and those of one method."""
    names = [v for n, v in vars(entities).items() if n.isupper() and isinstance(v, str)]
    method = entities.paths_of("NAME", 0)
    used = [*names, method.hs, method.vs, method.roi]
    roots = [v for v in names if any(other.startswith(f"{v}/") for other in used)]
    fixed = sorted(v for v in names if "/" in v and v not in roots)
    meaning = _attributes(entities.MethodPaths)
    rows = []
    for field in dataclasses.fields(method):
        value: Any = getattr(method, field.name)
        paths = (value,) if isinstance(value, str) else value
        rows.append(f"| {', '.join(f'`{p}`' for p in paths)} | {as_cell(meaning[field.name])} |")
    lines = [
        "# Entities of a recording",
        "",
        f"The time line is `{entities.TIMELINE}`, the time since the start of the sequence. "
        "[](../viewer.md) says what they contain.",
        "",
        *(f"- `{path}`" for path in fixed),
        "",
        "Of each method, by its name and its number in the recording, from 1:",
        "",
        "| entity | content |",
        "| --- | --- |",
        *rows,
    ]
    return "\n".join(lines) + "\n"
