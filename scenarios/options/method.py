"""The option that chooses a detector; its help lists every detector of the registry."""

from __future__ import annotations

from typing import Annotated

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
