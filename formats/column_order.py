"""The order of the columns t, x, y and p in a table without names, found by the values.

Over thousands of rows, only the time never falls, only the polarity has two values, and
coordinates are whole numbers within a sensor. x is assumed to come before y.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import permutations
from pathlib import Path

import numpy as np

from formats.columns import MAX_SIDE_PX, Array, Size
from formats.errors import FormatError

ORDERS_IN_USE = ("txyp", "xytp", "xypt")
"""Orders that other tools write: E-VID and v2e; MVSEC; Metavision."""

ROWS = 1 << 16
"""Rows that are examined, if there are so many."""

_CLEARLY_WORSE = 3
"""Rows that must contradict an order for a better one to be certain (assumed)."""
_DAMAGED_SHARE = 0.01
"""Largest share of rows that may contradict the order, as a few damaged ones do (assumed)."""
_NEVER = 1 << 30
"""Contradictions of an order that more than half of the rows contradict: it is not possible."""

_SENSOR_MAX_PX = 2048
"""Width that no event camera exceeds: the coordinates of EVT 3.0 have 11 bits [px]."""


def check_order(order: str) -> str:
    """Return an order that the user states, without separators.

    Args:
        order: a letter of each column, such as "txyp" or "t,x,y,p"; "-" for one that is not read.

    Raises:
        FormatError: a letter is missing, given twice or unknown.
    """
    letters = re.sub(r"[\s,;]", "", order.lower())
    if sorted(letters.replace("-", "")) != sorted("txyp"):
        raise FormatError(
            f"The order of columns is {order!r}. Allowed are the letters t, x, y and p, each once, "
            "and - for a column that is not read, such as txyp or xyt-p. Correct --columns."
        )
    return letters


def column_order(
    table: Array,
    option: str | None,
    size: Size | None,
    *,
    path: Path,
    not_whole: Sequence[int] = (),
) -> tuple[str, str]:
    """Return the order of the columns of a table, and what says so.

    Args:
        table: (n, columns) values of the first rows.
        option: order that the user states, as `check_order` returns it; None: not stated.
        size: width and height of the sensor, if known [px].
        path: path of the file, for error messages.
        not_whole: columns that a text file writes with decimals in every row, unlike others.

    Raises:
        FormatError: no order or several orders fit the values, or the stated one has another
            number of columns.
    """
    count = table.shape[1]
    if option is not None:
        if len(option) > count:
            raise FormatError(
                f"--columns is {option} and {path} has {count} columns. Allowed is a letter or - "
                "for each column. Correct --columns."
            )
        return option.ljust(count, "-"), "from --columns"
    rows = table[:ROWS, :4].astype(np.float64)
    order = _find(rows, path, not_whole)
    x, y = rows[:, order.index("x")], rows[:, order.index("y")]
    if size is not None and _outside(x, y, size) and not _outside(y, x, size):
        order = order.translate(str.maketrans("xy", "yx"))
    return order.ljust(count, "-"), f"found in the values of {len(rows):,} rows"


def _find(rows: Array, path: Path, not_whole: Sequence[int]) -> str:
    """Return the order of four columns by their values; x comes before y."""
    contradictions = _contradictions(rows, not_whole)
    fewest = min(contradictions.values())
    if fewest > max(_CLEARLY_WORSE, _DAMAGED_SHARE * len(rows)):
        raise FormatError(
            f"{path}: no order of the columns t, x, y and p fits their values ({_ranges(rows)}). "
            "Allowed are times that never decrease, polarities of 0 and 1 or -1 and 1, and whole "
            "numbers of pixels. State the order with --columns, such as --columns txyp."
        )
    orders = [o for o, found in contradictions.items() if found < fewest + _CLEARLY_WORSE]
    for criterion in (_fits_a_camera, _polarity_changes, _is_in_use):
        orders = [order for order in orders if criterion(order, rows)] or orders
    if len(orders) > 1:
        names = " and ".join(" ".join(order) for order in orders[:4])
        raise FormatError(
            f"{path}: the values in the first rows ({len(rows)}) do not show the order of the "
            f"columns. Possible are {names}. State the order with --columns, such as --columns "
            f"{orders[0]}."
        )
    return orders[0]


def _contradictions(rows: Array, not_whole: Sequence[int]) -> dict[str, int]:
    """Return the number of rows that contradict each order in which x comes before y."""
    falls = np.count_nonzero(np.diff(rows, axis=0) < 0, axis=0) + np.isnan(rows).sum(axis=0)
    on_off = [np.isin(rows, values).sum(axis=0) for values in ((0, 1), (-1, 1))]
    no_polarity = len(rows) - np.maximum(*on_off)
    whole = (rows == np.rint(rows)) & (rows >= 0) & (rows < MAX_SIDE_PX)
    no_coordinate = len(rows) - whole.sum(axis=0)
    no_coordinate[list(not_whole)] = len(rows)
    for found in (no_polarity, no_coordinate):
        found[found > len(rows) / 2] = _NEVER
    costs = {"t": falls, "x": no_coordinate, "y": no_coordinate, "p": no_polarity}
    orders = ("".join(order) for order in permutations("txyp"))
    return {
        order: sum(int(costs[name][i]) for i, name in enumerate(order))
        for order in orders
        if order.index("x") < order.index("y")
    }


def _fits_a_camera(order: str, rows: Array) -> bool:
    return all(bool((rows[:, order.index(name)] < _SENSOR_MAX_PX).all()) for name in "xy")


def _polarity_changes(order: str, rows: Array) -> bool:
    return bool(np.ptp(rows[:, order.index("p")]) > 0)


def _is_in_use(order: str, rows: Array) -> bool:
    del rows
    return order in ORDERS_IN_USE


def _outside(x: Array, y: Array, size: Size) -> bool:
    return bool((x >= size[0]).any() or (y >= size[1]).any())


def _ranges(rows: Array) -> str:
    return "; ".join(f"{column.min():g} to {column.max():g}" for column in rows.T)
