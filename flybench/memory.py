"""The memory budget: what large arrays need is counted before they are allocated.

Sensors, detectors, renderers and lists of events count what they keep, for as long as they live.
Whatever would exceed the budget is refused. Small arrays, the libraries and the graphics driver are
not counted; they take up to 1 GB (measured).
"""

from __future__ import annotations

import gc
import math
import os
import threading
import weakref

from flybench.errors import FlybenchError

DEFAULT_GB = 4.0
"""Memory budget of a process [GB]."""
OPTION, VARIABLE = "--memory-gb", "FLYBENCH_MEMORY_GB"
"""Option and environment variable that set the budget [GB]. The option sets the variable, so that
worker processes have the same budget."""

_counted: dict[int, int] = {}
"""Memory that each living owner has counted, by its `id` [bytes]."""
_lock = threading.RLock()
"""Reentrant, because the garbage collector may call `_release` in the middle of a call."""


class MemoryBudgetError(FlybenchError):
    """Something needs more memory than the budget allows, or the budget is invalid."""


def set_budget(memory_gb: float) -> None:
    """Set the memory budget of this process and of those that it starts [GB].

    Raises:
        MemoryBudgetError: the budget is not a positive finite number.
    """
    _check_budget(OPTION, memory_gb)
    os.environ[VARIABLE] = repr(memory_gb)


def budget_gb() -> float:
    """Return the memory budget of this process [GB].

    Raises:
        MemoryBudgetError: the environment variable is not a positive finite number.
    """
    text = os.environ.get(VARIABLE, "")
    if not text:
        return DEFAULT_GB
    try:
        memory_gb = float(text)
    except ValueError:
        memory_gb = math.nan
    _check_budget(VARIABLE, memory_gb, text)
    return memory_gb


def free_bytes() -> int:
    """Return the part of the budget that is not counted yet [bytes]."""
    return max(0, round(budget_gb() * 1e9) - _in_use(None))


def check_memory(what: str, needed: int, *, owner: object = None) -> None:
    """Refuse to allocate memory that does not fit into the budget beside what is counted.

    Args:
        what: what needs the memory, as the subject of a sentence in the singular.
        needed: memory that it needs at its peak [bytes].
        owner: object whose own memory this replaces, such as one that grows; None: there is none.

    Raises:
        MemoryBudgetError: the memory does not fit.
    """
    limit = budget_gb() * 1e9
    if needed + _in_use(owner) <= limit:
        return
    gc.collect()  # what nobody can reach any more is not in use
    in_use = _in_use(owner)
    if needed + in_use <= limit:
        return
    beside = f" Other objects use {_gb(in_use)} of it." if in_use >= 0.01 * limit else ""
    raise MemoryBudgetError(
        f"{what} needs {_gb(needed)} of memory. Allowed is {_gb(limit)}.{beside} Choose something "
        f"smaller, or allow more with {OPTION} (in Python: the environment variable {VARIABLE})."
    )


def count_memory(owner: object, what: str, needed: int) -> None:
    """Count the memory of an object against the budget until the object is deleted.

    Call this before the memory is allocated, and again before it grows.

    Args:
        owner: the object.
        what: what needs the memory, as the subject of a sentence in the singular.
        needed: all memory that the object needs at its peak [bytes].

    Raises:
        MemoryBudgetError: the memory does not fit.
    """
    with _lock:
        check_memory(what, needed, owner=owner)
        if id(owner) not in _counted:
            weakref.finalize(owner, _release, id(owner)).atexit = False
        _counted[id(owner)] = needed


def _in_use(owner: object) -> int:
    with _lock:
        return sum(_counted.values()) - _counted.get(id(owner), 0)


def _release(owner_id: int) -> None:
    with _lock:
        _counted.pop(owner_id, None)


def _check_budget(name: str, memory_gb: float, text: str | None = None) -> None:
    if not 0.0 < memory_gb < math.inf:
        raise MemoryBudgetError(
            f"{name} is {memory_gb if text is None else text!r}. Allowed is a number of GB above "
            f"0. The default is {DEFAULT_GB:g}."
        )


def _gb(size: float) -> str:
    return f"{size / 1e9:.3g} GB"
