"""Where the numbers of the pixels of a batch are in its flat array: the start of each field.

Import it as a whole, `from emulator.pixel import fields as at`: `own[at.LAG + k]` is then the lag
of the pixel at position k.
"""

from __future__ import annotations

BATCH = 512
"""Pixels in a batch: its 40 fields take 169 kB, which fit into the caches of a core."""

STRIDE = BATCH + 16
"""Distance between the starts of two fields. A power of two would put the same pixel of all fields
into one set of the cache."""

(
    LUMINANCE_FROM,
    LUMINANCE_TO,
    LOG_FROM,
    LAG,
    CHANGE,
    LEAK,
    CLOCK,
    THETA_ON,
    THETA_OFF,
    HOT_RATE,
    DARK_LUX,
    LEAK_FACTOR,
    SECOND_LAG,
    REST,
    LOG_TO,
    NEW_LAG,
    NEW_CHANGE,
    NEW_LEAK,
    NEW_CLOCK,
    NEW_SECOND_LAG,
    DRIFT,
    CORNER,
    END,
    OUTCOME,
    EVENT_TIME,
    MARK,
    SIGMA,
    START,
    RESET,
    SLOPE,
    SPAN,
    FIRST,
    SECOND,
    EARLIEST,
    LATEST,
    LEVEL,
    SIDE,
    USED,
    CHOICE,
    GAUSSIAN,
) = (field * STRIDE for field in range(40))
"""Start of each field."""

FIELDS = 40
