import pytest

from scenarios.output.numbers import counted, plain_number


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1e-12, "0"),
        (80_512.0, "80\u202f500"),
        (999.6, "1\u202f000"),
        (1234567.0, "1\u202f230\u202f000"),
        (-1.2345, "−1.23"),
        (100.0, "100"),
        (20.0, "20"),
        (0.00041, "0.00041"),
        (float("nan"), "–"),
    ],
)
def test_numbers_have_three_digits_and_no_exponent(value: float, text: str) -> None:
    assert plain_number(value) == text


def test_the_number_of_digits_can_be_chosen() -> None:
    assert plain_number(98.76, 2) == "99"


def test_a_noun_is_singular_only_after_1() -> None:
    assert [counted(n, "step") for n in (0, 1, 2_000)] == ["0 steps", "1 step", "2,000 steps"]
