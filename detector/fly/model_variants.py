"""Model variants: the choices that the paper leaves open, so that they can be compared.

The first table gives their effect on synthetic targets of 120 px, contrast 0.4, at 240 to 960 px/s
in four directions and in noise of 1 and 10 Hz per pixel (40 streams). Everything else is as in the
paper preset. "Right" and "wrong" are shares of the steps after 100 ms in view [%]; the other steps
were `NONE`. "IoU" and "centre" compare the region and the view centre with the truth. "Noise" is
the share of steps that named a direction in noise alone of 10 and of 20 Hz per pixel (100 steps
each).

| model variant            | right | wrong | IoU  | centre | noise    |
| ------------------------ | ----- | ----- | ---- | ------ | -------- |
| paper preset             |  99.5 |   0.1 | 0.41 |  29 px | 0 %, 0 % |
| time_surface = itself    |  98.6 |   0.1 | 0.36 |  29 px | 0 %, 1 % |
| neighbourhood_px = 1     |  99.5 |   0.0 | 0.42 |  29 px | 3 %, 6 % |
| averaging = both         |  99.6 |   0.1 | 0.42 |  28 px | 0 %, 0 % |
| averaging = area         |  89.3 |   8.1 | 0.48 |  22 px | 0 %, 0 % |
| averaging = none         |  55.6 |  15.0 | 0.48 |  22 px | 0 %, 0 % |
| offsets = doubling       |  99.9 |   0.0 | 0.42 |  28 px | 0 %, 0 % |
| pair_location = delayed  |  89.0 |   0.9 | 0.42 |  27 px | 0 %, 3 % |
| attention = maximum      |  99.2 |   0.1 | 0.44 |  25 px | 0 %, 0 % |
| attention = everywhere   |  99.9 |   0.1 | 0.05 |  82 px | 0 %, 0 % |
| local_motion = cell      |  99.1 |   0.1 | 0.44 |  25 px | 0 %, 0 % |
| roi_activity = present   |  99.5 |   0.1 | 0.42 |  29 px | 0 %, 0 % |
| roi_radius_px = 150      |  99.9 |   0.1 | 0.45 |  28 px | 0 %, 0 % |
| normalisation = total    |  99.4 |   0.2 | 0.41 |  29 px | 0 %, 0 % |
| snr_floor = 0            |  99.8 |   0.2 | 0.41 |  29 px | 0 %, 3 % |
| wide preset              | 100.0 |   0.0 | 0.41 |  29 px | 0 %, 0 % |

It was measured with share_floor = 0. On other synthetic targets of this kind (20 streams) the
floor removes no right step from any variant. In noise it reduces the steps that name a direction
with snr_floor = 0 from 7 to 3 %.

GRMS can be computed in several ways too (`detector.metrics.grms`). The second table is for rendered
crossings, each seen by ten sensors. It gives in how many of them GRMS rises through all four
velocities, and how far GRMS scatters from sensor to sensor (mean standard deviation over the mean).
The default was chosen on the three streets, at 1.0, 1.4, 1.8 and 2.2 rad/s; "paper" is the paper's
street and velocities.

| of     | step   | three streets, day | night         | paper, day       | night         |
| ------ | ------ | ------------------ | ------------- | ---------------- | ------------- |
| winner |  50 ms | 30 of 30,  1.3 %   | 30 of 30, 2 % | 10 of 10,  1.3 % | 10 of 10, 2 % |
| winner |  10 ms | 30 of 30,  5.2 %   | 30 of 30, 5 % |  9 of 10,  6.8 % | 10 of 10, 2 % |
| both   |  50 ms | 30 of 30,  3.3 %   | 30 of 30, 2 % | 10 of 10,  3.5 % | 10 of 10, 2 % |
| both   |  10 ms | 26 of 30, 13.3 %   | 30 of 30, 5 % |  9 of 10, 11.0 % | 10 of 10, 2 % |

By day the response of the weaker system is noise, and so is a good part of what changes within
10 ms. The gradient squares this noise.
"""

from __future__ import annotations

from enum import StrEnum


class SurfaceEvents(StrEnum):
    """The events that make up the time surface of an event (equation 3)."""

    EARLIER = "earlier"
    """Strictly earlier events, as printed. An isolated event scores 0."""
    ITSELF = "itself"
    """Earlier events and the event itself. An isolated event scores 1."""
    SATURATING = "saturating"
    """All events of its pixel, each a share of what is missing to 1, when the estimate is due."""


class Averaging(StrEnum):
    """The divisor of the sum over a cell's events (equation 5)."""

    EVENTS = "events"
    """Number of events of this polarity in the cell and the window."""
    BOTH = "both"
    """Number of events of both polarities: |C| before equations 6 and 7 separate them."""
    AREA = "area"
    """Number of pixels in a cell. Few events then count for little."""
    NONE = "none"
    """No division: the histogram of equation 4."""


class Offsets(StrEnum):
    """The series of correlation distances in equation 9."""

    EVEN = "even"
    """sd, 2·sd, 3·sd, … n_c·sd: the printed limits, read as multiples of sd."""
    DOUBLING = "doubling"
    """sd, 2·sd, 4·sd, … 2^(n_c − 1)·sd: many scales from few distances."""


class ReceptiveFields(StrEnum):
    """The size of the two points of a pair in equation 9."""

    CELL = "cell"
    """One cell, as printed."""
    DISTANCE = "distance"
    """As wide as the pair is long, like the facets of an eye. Finer detail, which a pair of this
    length would take for motion in another direction, is averaged out."""


class PairLocation(StrEnum):
    """The cell that the correlation of a pair belongs to (equation 9)."""

    MIDPOINT = "midpoint"
    """The midpoint of the pair. The edge of a region cuts pairs of opposite directions alike."""
    DELAYED = "delayed"
    """The point with the delayed signal, as printed."""


class Attention(StrEnum):
    """How the view centre is placed (equations 10 to 15)."""

    STEERED = "steered"
    """The steering response moves it towards the most salient cell."""
    MAXIMUM = "maximum"
    """It is the most salient cell, as in equation 10 read alone."""
    EVERYWHERE = "everywhere"
    """No attention: the whole field is the region of interest."""


class LocalMotion(StrEnum):
    """What the local motion response is relative to (equation 13)."""

    SHARE = "share"
    """The total of both directions: in [−1, 1], so that its gain is a distance."""
    CELL = "cell"
    """Nothing; it is taken at the one cell of the view centre, as printed."""


class RegionActivity(StrEnum):
    """The activity on which the region of interest grows (equation 16)."""

    BOTH = "both"
    """Present and delayed surfaces, so that both points of the correlated pairs lie inside."""
    PRESENT = "present"
    """Present surfaces only."""


class Normalisation(StrEnum):
    """How a response is mapped into (−1, 1)."""

    CELLS = "cells"
    """Sigmoid of the response over the number of cells. Strength distinguishes slow from fast."""
    TOTAL = "total"
    """Share of the sum of both directions. Strength is the degree of agreement."""
    ALL = "all"
    """Share of the sum of all four directions, so that both systems are divided by the same."""


class GrmsResponse(StrEnum):
    """The response whose gradient GRMS measures (figure 5 B)."""

    WINNER = "winner"
    """The response of the stronger system at each step: the output of the model (section II-D)."""
    BOTH = "both"
    """The responses of both systems."""
