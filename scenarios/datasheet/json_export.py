"""The data sheet as JSON, with every figure and every curve."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from emulator.characterisation import Datasheet, Plot, Quantity, Section, Series
from scenarios.output.atomic_folder import GENERATOR


def datasheet_dict(
    sheet: Datasheet, *, changes: Mapping[str, Any], versions: Mapping[str, str]
) -> dict[str, Any]:
    """Return the data sheet as plain lists, strings and finite numbers.

    Args:
        sheet: results of the experiments.
        changes: preset of the sensor and its changed settings, by name.
        versions: versions of the programs used, by name.
    """
    return {
        "generator": GENERATOR,
        "asked_for": dict(changes),
        "seed": sheet.seed,
        "versions": dict(versions),
        "sensor": asdict(sheet.config),
        "sections": {name: _section(section) for name, section in sheet.sections.items()},
    }


def _section(section: Section) -> dict[str, Any]:
    return {
        "title": section.title,
        "method": section.method,
        "figures": [_quantity(quantity) for quantity in section.quantities],
        "plots": [_plot(plot) for plot in section.plots],
    }


def _quantity(quantity: Quantity) -> dict[str, Any]:
    published = quantity.published
    return {
        "name": quantity.name,
        "unit": quantity.unit,
        "measured": _finite(quantity.measured),
        "published": None if published is None else published.value,
        "difference": _finite(quantity.difference),
        "source": None if published is None else published.source,
        "published_for_another_sensor": published is not None and published.another_sensor,
        "note": quantity.note,
    }


def _plot(plot: Plot) -> dict[str, Any]:
    return {
        "title": plot.title,
        "x": plot.x_label,
        "y": plot.y_label,
        "series": [_series(series) for series in plot.series],
    }


def _series(series: Series) -> dict[str, Any]:
    return {
        "label": series.label,
        "style": series.style.value,
        "x": [_finite(value) for value in series.x.tolist()],
        "y": [_finite(value) for value in series.y.tolist()],
    }


def _finite(value: float | None) -> float | None:
    """Return the number; None for NaN and infinities, which JSON does not have."""
    return value if value is not None and math.isfinite(value) else None
