"""The options that choose a detector and a filter before it; their help lists all names."""

from __future__ import annotations

from typing import Annotated, Literal

import tyro

from detector.denoise import FILTERS
from scenarios.pipeline.registry import DETECTORS

ALLOWED_METHODS = (
    f"{', '.join(DETECTORS)}, or your own class, as package.module:Class; with a filter of events "
    f"before it ({', '.join(FILTERS)}), as stcf+fly"
)
"""Names that `--method` takes, for the help."""

MethodName = Annotated[
    str, tyro.conf.arg(metavar="NAME", help=f"Name of the detector: {ALLOWED_METHODS}.")
]
"""One detector."""

MethodNames = Annotated[
    tuple[str, ...],
    tyro.conf.arg(
        metavar="NAME ...", help=f"Names of the detectors to compare: {ALLOWED_METHODS}."
    ),
]
"""One detector or more, after one option."""

RepeatedMethod = Annotated[
    tuple[str, ...],
    tyro.conf.arg(
        metavar="NAME",
        help=f"Name of a detector: {ALLOWED_METHODS}. Repeat the option to measure several.",
        help_behavior_hint="(default: fly)",
    ),
    tyro.conf.UseAppendAction,
]
"""One or more detectors, each given by a separate option."""

FilterName = Annotated[
    Literal["baf", "stcf", "time-surface", "double-window"] | None,
    tyro.conf.arg(
        metavar="|".join(FILTERS),
        help="Filter of noise that the events pass before the detector; see `flybench denoise`.",
        help_behavior_hint="(default: no filter)",
    ),
]
"""One filter, or none."""


def behind_filter(event_filter: FilterName, method: str) -> str:
    """Return the name of a method behind a filter, such as "stcf+fly"."""
    return method if event_filter is None else f"{event_filter}+{method}"
