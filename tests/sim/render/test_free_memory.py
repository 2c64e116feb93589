"""How much memory a sequence takes, in a process of its own: no more, however long it is."""

import ctypes
import platform
import subprocess
import sys
from types import SimpleNamespace

import pytest

from sim.render.free_memory import return_free_memory, return_large_blocks

LIMIT_MB = 1_000
"""Promised: a sequence of any length in under 1 GB."""
SAMPLE_MB = 0.8
"""A sample's light and bodies: what would stay behind of each if it were held."""
MEASURE = """
import re
from pathlib import Path
from sim import Crossing, CrossingConfig

def peak_mb():  # of this program: getrusage counts that of its parent before it began
    status = Path("/proc/self/status").read_text()
    return int(re.search(r"VmHWM:\\s+(\\d+)", status)[1]) / 1e3

crossing = Crossing(CrossingConfig(lighting="night", lead_s=2.0, step_px=8.0, max_step_ms=4.0))
taken = []
for sample in crossing.samples():
    taken.append(peak_mb())
left = sum(us < 1.5e6 for us in crossing.times_us())
print(left, len(taken), taken[left - 1] - taken[50], taken[-1])
"""


def measured() -> list[float]:
    """Samples until 0.5 s before the vehicle enters, and all; growth until then, and peak [MB]."""
    command = [sys.executable, "-c", MEASURE]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    return [float(word) for word in answer.stdout.split()]


def test_frames_stream_and_the_whole_takes_less_than_a_gigabyte() -> None:
    early, count, grown_mb, peak_mb = measured()
    assert early > 300
    assert count > 2 * early
    assert grown_mb < 0.1 * SAMPLE_MB * early
    if peak_mb >= LIMIT_MB:  # where it was the first to call kernels, it compiled them
        *_, peak_mb = measured()
    assert peak_mb < LIMIT_MB


def test_the_c_library_takes_what_it_is_told() -> None:
    assert return_large_blocks() == (platform.libc_ver()[0] == "glibc")


def test_the_c_library_is_asked_for_all_that_is_free(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    library = SimpleNamespace(malloc_trim=asked.append)
    monkeypatch.setattr(ctypes, "CDLL", lambda _: library)
    return_free_memory()
    assert asked == [0]


def test_a_c_library_that_cannot_is_borne(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
    return_free_memory()
    assert not return_large_blocks()
