"""The readout: how often a time stamp holds several rows, and the highest event rate.

Neither is a parameter of the sensor. They show whether the readout of the emulated sensor is like
that of the camera (`flybench compare`).
"""

from __future__ import annotations

import numpy as np

from emulator.characterisation import Quantity, Section
from flybench.events import Events
from scenarios.calibrate.fit import Fit, unknown
from scenarios.event_statistics.readout_order import ReadoutOrder, ReadoutShares

_MS_US = 1000
_FEWEST_STAMPS = 1000
"""Fewest time stamps of a class of event rates that is reported (assumed)."""


def readout_page(events: Events) -> Fit:
    """Return the order of rows at each event rate, and the highest rate."""
    order = ReadoutOrder()
    order.add(events)
    rows = [
        quantity
        for shares in order.shares()
        if shares.stamps >= _FEWEST_STAMPS
        for quantity in _rows(shares)
    ]
    t = events["t"] - events["t"][0]
    highest = float(np.bincount(t // _MS_US).max()) / _MS_US
    rows.append(Quantity("highest event rate in 1 ms", "Mev/s", highest))
    method = (
        "Rows that share a time stamp, and steps from one row to the next, as flybench compare "
        "counts them. The rate of the bus shows only when it is saturated."
    )
    reason = f"nothing shows that the bus was saturated; it carried {highest:.3g} Mev/s"
    limit = unknown("readout.limit_hz", "Hz", reason)
    return Fit("readout", (limit,), Section("Readout", method, rows))


def _rows(shares: ReadoutShares) -> list[Quantity]:
    at = f"from {shares.from_mev_s:g} Mev/s"
    several = None if shares.one_row is None else 1.0 - shares.one_row
    return [
        Quantity(f"time stamps with several rows, {at}", "", several),
        Quantity(f"steps to a neighbouring row, {at}", "", shares.to_neighbour),
        Quantity(f"steps downwards, {at}", "", shares.down),
    ]
