"""Lines and markers of day and night, in the colour of the method."""

from __future__ import annotations

from typing import Any


def lighting_style(lighting: str, colour: str) -> dict[str, Any]:
    """Return the line style of a lighting: filled and solid by day, else hollow and dashed."""
    is_day = lighting == "day"
    return {
        "color": colour,
        "linestyle": "-" if is_day else (0, (4, 2)),
        "linewidth": 1.7,
        "markersize": 6,
        "markerfacecolor": colour if is_day else "white",
        "markeredgecolor": colour,
        "markeredgewidth": 1.4,
    }
