import numpy as np
import pytest

from sim.scene.srgb import decoded, encoded


def test_known_codes() -> None:
    assert encoded([0.0, 1.0]) == pytest.approx([0.0, 1.0])
    assert decoded(0.5) == pytest.approx(0.2140, abs=1e-4)
    assert encoded(0.18) == pytest.approx(0.4614, abs=1e-4)


def test_encoding_and_decoding_are_inverse() -> None:
    value = np.linspace(0, 1, 101)
    assert decoded(encoded(value)) == pytest.approx(value, abs=1e-6)
