"""What the paper leaves open, as choices: every reading can be selected and compared.

Their effect on drawn targets of 120 px, contrast 0.4, at 240 to 960 px/s in four directions and
noise of 1 and 10 Hz a pixel (40 streams), everything else as in the paper preset. Right and wrong
are shares of the steps after 100 ms in view, the rest said none; IoU and centre compare the region
and the view centre with the truth; noise is the share of steps that named a direction in noise
alone of 10 and 20 Hz a pixel (100 steps each).

| reading                  | right | wrong | IoU  | centre | noise    |
| ------------------------ | ----- | ----- | ---- | ------ | -------- |
| paper preset             |  99.5 |   0.1 | 0.41 |  29 px | 0 %, 0 % |
| time_surface = itself    |  98.6 |   0.1 | 0.36 |  29 px | 0 %, 1 % |
| neighbourhood_px = 1     |  99.5 |   0.0 | 0.42 |  29 px | 3 %, 6 % |
| averaging = both         |  99.6 |   0.1 | 0.42 |  28 px | 0 %, 0 % |
| averaging = area         |  89.3 |   8.1 | 0.48 |  22 px | 0 %, 0 % |
| averaging = none         |  55.6 |  15.0 | 0.48 |  22 px | 0 %, 0 % |
| offsets = doubling       |  99.9 |   0.0 | 0.42 |  28 px | 0 %, 0 % |
| pair_location = delayed       |  89.0 |   0.9 | 0.42 |  27 px | 0 %, 3 % |
| attention = maximum      |  99.2 |   0.1 | 0.44 |  25 px | 0 %, 0 % |
| attention = everywhere   |  99.9 |   0.1 | 0.05 |  82 px | 0 %, 0 % |
| local_motion = cell      |  99.1 |   0.1 | 0.44 |  25 px | 0 %, 0 % |
| roi_activity = present   |  99.5 |   0.1 | 0.42 |  29 px | 0 %, 0 % |
| roi_radius_px = 150      |  99.9 |   0.1 | 0.45 |  28 px | 0 %, 0 % |
| normalisation = total    |  99.4 |   0.2 | 0.41 |  29 px | 0 %, 0 % |
| snr_floor = 0            |  99.8 |   0.2 | 0.41 |  29 px | 0 %, 3 % |
| wide preset              | 100.0 |   0.0 | 0.41 |  29 px | 0 %, 0 % |

It was measured with share_floor = 0. On other drawings of such targets (20 streams) the floor takes
no right step from any reading; in noise it takes what names a direction with snr_floor = 0 from
7 to 3 %.

GRMS can be read in several ways too (`detector.metrics.grms`). Of rendered crossings seen by ten
sensors each: in how many of them it rises through all four velocities, and how far it scatters
from sensor to sensor, as the mean standard deviation over the mean. Three streets at 1.0, 1.4, 1.8
and 2.2 rad/s, on which the default was chosen, and the paper's street and velocities:

| of     | step   | three streets: day | night        | the paper's: day | night        |
| ------ | ------ | ------------------ | ------------ | ---------------- | ------------ |
| winner |  50 ms | 30 of 30,  1.3 %   | 30 of 30, 2 % | 10 of 10,  1.3 % | 10 of 10, 2 % |
| winner |  10 ms | 30 of 30,  5.2 %   | 30 of 30, 5 % |  9 of 10,  6.8 % | 10 of 10, 2 % |
| both   |  50 ms | 30 of 30,  3.3 %   | 30 of 30, 2 % | 10 of 10,  3.5 % | 10 of 10, 2 % |
| both   |  10 ms | 26 of 30, 13.3 %   | 30 of 30, 5 % |  9 of 10, 11.0 % | 10 of 10, 2 % |

By day the weaker system is noise, and so is a good part of what changes within 10 ms; a gradient
squares it.
"""

from __future__ import annotations

from enum import StrEnum


class TimeSurface(StrEnum):
    """Which events make up the time surface of an event (equation 3)."""

    EARLIER = "earlier"
    """Strictly earlier ones, as printed: an isolated event scores 0."""
    ITSELF = "itself"
    """The event too: an isolated event scores 1."""


class Averaging(StrEnum):
    """What the sum over a cell's events is divided by (equation 5)."""

    EVENTS = "events"
    """The number of the cell's events of that polarity in the window."""
    BOTH = "both"
    """The number of the cell's events of both polarities: |C| before equations 6 and 7 part it."""
    AREA = "area"
    """The number of pixels in a cell: few events then count for little."""
    NONE = "none"
    """Nothing: the histogram of equation 4."""


class Offsets(StrEnum):
    """How the correlation distances of equation 9 follow one another."""

    EVEN = "even"
    """sd, 2·sd, 3·sd, … n_c·sd: the printed limits, read as steps of sd."""
    DOUBLING = "doubling"
    """sd, 2·sd, 4·sd, … 2^(n_c − 1)·sd: many scales from few distances."""


class PairLocation(StrEnum):
    """The cell to which the correlation of a pair belongs (equation 9)."""

    MIDPOINT = "midpoint"
    """The middle of the pair: the edge of a region cuts pairs of opposite directions alike."""
    DELAYED = "delayed"
    """The point with the delayed signal, as printed."""


class Attention(StrEnum):
    """How the view centre finds its place (equations 10 to 15)."""

    STEERED = "steered"
    """By the steering response, towards the most salient cell."""
    MAXIMUM = "maximum"
    """It is the most salient cell, as equation 10 has it when read alone."""
    EVERYWHERE = "everywhere"
    """No attention: the whole field is the region of interest."""


class LocalMotion(StrEnum):
    """What the local motion response is relative to (equation 13)."""

    SHARE = "share"
    """The total of both directions: in [−1, 1], so that its gain is a distance."""
    CELL = "cell"
    """Nothing, at the one cell of the view centre, as printed."""


class RegionActivity(StrEnum):
    """What the region of interest grows on (equation 16)."""

    BOTH = "both"
    """Present and delayed surfaces: both arms of the correlations lie inside."""
    PRESENT = "present"
    """Present surfaces."""


class Normalisation(StrEnum):
    """How a response is brought into (−1, 1)."""

    CELLS = "cells"
    """A sigmoid of the response over the number of cells: strength tells slow from fast."""
    TOTAL = "total"
    """Its share of the sum of both directions: strength tells how much agrees."""


class GrmsOf(StrEnum):
    """The response whose gradient GRMS takes (figure 5 B)."""

    WINNER = "winner"
    """The stronger system's at each step, which is what the model puts out (section II-D)."""
    BOTH = "both"
    """Those of both systems."""
