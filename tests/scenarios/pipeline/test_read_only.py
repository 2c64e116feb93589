"""Read-only copies."""

import numpy as np
import pytest

from scenarios.pipeline.read_only import read_only_copy
from tests.scenarios.timed_events import events_at


def test_a_copy_equals_its_array_and_can_never_be_written_to() -> None:
    for array in (events_at(1, 2), events_at(), np.arange(6, dtype=np.uint16).reshape(2, 3)):
        copy = read_only_copy(array)
        assert np.array_equal(copy, array)
        assert copy.dtype == array.dtype
        with pytest.raises(ValueError, match="WRITEABLE"):
            copy.setflags(write=True)
        with pytest.raises(ValueError, match="read-only"):
            copy[:0] = copy[:0]
