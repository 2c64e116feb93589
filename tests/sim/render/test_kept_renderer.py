"""The renderer that is kept from one crossing to the next."""

import threading
from collections.abc import Iterator

import numpy as np
import pytest

from sim import Crossing, CrossingConfig, Distractors, Lighting
from sim.render.kept_renderer import kept_renderer


def renderers() -> list[threading.Thread]:
    """Return the threads that own a renderer at present."""
    return [thread for thread in threading.enumerate() if thread.name == "renderer"]


def crossing(omega_rad_s: float, lighting: Lighting = Lighting.DAY, **options: object) -> Crossing:
    return Crossing(
        CrossingConfig(lighting=lighting, omega_rad_s=omega_rad_s, step_px=4.0, **options)  # type: ignore[arg-type]
    )


def images(crossed: Crossing) -> list[np.ndarray]:
    times = crossed.times_us()
    middle = len(times) // 2
    return [sample.luminance for sample in crossed.samples(times[middle - 3 : middle + 3])]


@pytest.fixture(autouse=True)
def none_open() -> Iterator[None]:
    assert not renderers()
    yield
    assert not renderers()


def test_a_kept_renderer_draws_the_same_bits() -> None:
    flickering = {"distractors": Distractors(flicker_hz=100)}
    wanted = [images(crossing(omega, Lighting.NIGHT, **flickering)) for omega in (2.0, 3.0)]
    with kept_renderer():
        found = [images(crossing(omega, Lighting.NIGHT, **flickering)) for omega in (2.0, 3.0)]
    np.testing.assert_array_equal(found, wanted)


def test_it_is_kept_for_the_same_model_and_replaced_for_another() -> None:
    with kept_renderer():
        images(crossing(2.0))
        first = renderers()
        images(crossing(3.0))
        assert renderers() == first
        images(crossing(3.0, paint_reflectance=0.7))
        second = renderers()
        assert len(second) == 1
        assert second != first


def test_it_is_not_kept_outside_or_after_unread_samples() -> None:
    images(crossing(2.0))
    assert not renderers()
    with kept_renderer():
        unread = crossing(2.0).samples()
        next(unread)
        assert len(renderers()) == 1
        unread.close()  # type: ignore[attr-defined]
        assert not renderers()


def test_two_crossings_at_once_have_a_renderer_each() -> None:
    with kept_renderer():
        images(crossing(2.0))
        one, other = crossing(2.0).samples(), crossing(2.0).samples()
        np.testing.assert_array_equal(next(one).luminance, next(other).luminance)
        assert len(renderers()) == 2
        for samples in (one, other):
            assert sum(1 for _ in samples) > 1
        assert len(renderers()) == 1
