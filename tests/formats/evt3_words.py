"""An encoder of EVT 3.0 that uses every kind of word."""

import numpy as np

from flybench.events import Events


def evt3_words(events: Events) -> np.ndarray:
    """Encode events in all three ways: alone, and in vectors of 12 and 8 pixels."""
    words: list[int] = []
    for k, (t, x, y, p) in enumerate(events.tolist()):
        words += [8 << 12 | (t >> 12) & 0xFFF, 6 << 12 | t & 0xFFF, y]
        if k % 3 == 0 or x < 20:
            words.append(2 << 12 | p << 11 | x)
        else:  # an empty vector moves x on by its length
            words += [3 << 12 | p << 11 | (x - 20), 4 << 12, 5 << 12]
            words += [5 << 12 | 1] if k % 3 == 1 else [4 << 12 | 1]
    return np.array(words, "<u2")
