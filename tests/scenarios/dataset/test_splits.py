"""Values that splits share out."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.dataset.splits import apportion, divide
from scenarios.errors import ScenarioError
from scenarios.sweep.random_sample import CHOICE, LOG_UNIFORM, UNIFORM, Distribution

STREET, VEHICLE = "crossing.street_seed", "crossing.vehicle"


@given(st.lists(st.integers(1, 1000), min_size=1, max_size=5), st.integers(0, 10_000))
def test_every_share_is_at_least_one_and_nearly_proportional(counts: list[int], more: int) -> None:
    total = len(counts) + more
    shares = apportion(total, counts)
    assert sum(shares) == total
    assert min(shares) >= 1
    exact = [1 + more * count / sum(counts) for count in counts]
    assert all(abs(share - e) < 1 for share, e in zip(shares, exact, strict=True))


def test_whole_numbers_are_divided_into_ranges_without_a_common_value() -> None:
    parts = divide(Distribution(STREET, UNIFORM, (10, 19)), {"train": 8, "val": 1, "test": 1})
    assert {name: part.values for name, part in parts.items()} == {
        "train": (10, 15),
        "val": (16, 17),
        "test": (18, 19),
    }
    assert set(parts["test"].draw(5, seed=0)) == {18, 19}
    drawn = {name: set(part.draw(200, seed=0)) for name, part in parts.items()}
    assert drawn["train"] == set(range(10, 16))
    assert not drawn["train"] & drawn["val"]


def test_choices_are_divided_in_their_order() -> None:
    kinds = Distribution(VEHICLE, CHOICE, ("sedan", "van", "sedan", "motorcycle"))
    parts = divide(kinds, {"train": 2, "test": 1})
    assert parts["train"].values == ("sedan", "van")
    assert parts["test"].values == ("motorcycle",)


@pytest.mark.parametrize(
    ("distribution", "message"),
    [
        (Distribution(VEHICLE, CHOICE, ("sedan", "van")), "2 different values for 3 splits"),
        (Distribution(STREET, UNIFORM, (3, 4)), "2 different values for 3 splits"),
        (Distribution("crossing.omega_rad_s", UNIFORM, (1.0, 2.0)), "or whole numbers by"),
        (Distribution(STREET, LOG_UNIFORM, (1, 100)), "or whole numbers by"),
    ],
)
def test_what_cannot_be_divided_is_refused(distribution: Distribution, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        divide(distribution, {"train": 1, "val": 1, "test": 1})
    assert f"splits.disjoint holds {distribution.name}" in str(caught.value)
