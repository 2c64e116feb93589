import gc

import pytest

from flybench.memory import (
    DEFAULT_GB,
    VARIABLE,
    MemoryBudgetError,
    budget_gb,
    check_memory,
    count_memory,
    set_budget,
)


class Owner:
    """Object that counts memory."""


@pytest.fixture(autouse=True)
def _one_kilobyte(monkeypatch: pytest.MonkeyPatch) -> None:
    gc.collect()
    monkeypatch.setattr("flybench.memory._counted", {})
    monkeypatch.setenv(VARIABLE, "1e-6")


def test_the_default_is_four_gigabytes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE)
    assert budget_gb() == DEFAULT_GB == 4.0


def test_a_refusal_names_the_need_the_limit_and_the_option() -> None:
    check_memory("A sensor", 1000)
    with pytest.raises(MemoryBudgetError) as refusal:
        check_memory("A sensor of 30000×30000 px", 144_000_000_000)
    for part in ("A sensor of 30000×30000 px needs 144 GB", "Allowed is 1e-06 GB", "--memory-gb"):
        assert part in str(refusal.value)


def test_living_objects_add_up() -> None:
    first, second = Owner(), Owner()
    count_memory(first, "The first", 600)
    with pytest.raises(MemoryBudgetError, match="Other objects use 6e-07 GB of it"):
        count_memory(second, "The second", 600)
    count_memory(second, "The second", 400)


def test_a_deleted_object_is_not_counted() -> None:
    first = Owner()
    count_memory(first, "The first", 1000)
    del first
    check_memory("The second", 1000)


def test_an_unreachable_cycle_is_not_counted() -> None:
    first = Owner()
    first.itself = first  # type: ignore[attr-defined]
    count_memory(first, "The first", 1000)
    del first
    check_memory("The second", 1000)


def test_an_object_that_grows_replaces_its_own_memory() -> None:
    owner = Owner()
    count_memory(owner, "It", 600)
    count_memory(owner, "It", 1000)
    with pytest.raises(MemoryBudgetError):
        count_memory(owner, "It", 1001)
    check_memory("It", 1000, owner=owner)


def test_the_budget_passes_on_to_child_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    set_budget(2.5)
    assert budget_gb() == 2.5
    monkeypatch.setenv(VARIABLE, "")
    assert budget_gb() == DEFAULT_GB


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "much"])
def test_an_invalid_budget_is_refused(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(MemoryBudgetError, match=f"{VARIABLE} is '{text}'. Allowed is a number"):
        budget_gb()


@pytest.mark.parametrize("memory_gb", [0.0, -1.0, float("nan"), float("inf")])
def test_an_invalid_option_is_refused(memory_gb: float) -> None:
    with pytest.raises(MemoryBudgetError, match="--memory-gb is"):
        set_budget(memory_gb)
