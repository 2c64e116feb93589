"""Peak memory of a sequence, measured in a separate process; it does not grow with length."""

import ctypes
import platform
import subprocess
import sys
from types import SimpleNamespace

import pytest

from sim.render.free_memory import return_free_memory, return_large_blocks

LIMIT_MB = 1_000
"""Required limit: a sequence of any length takes less than 1 GB."""
SAMPLE_MB = 0.8
"""Size of a sample's luminance and body labels, which would add up if samples were kept."""
MEASURE = """
import re
from pathlib import Path
from sim import Crossing, CrossingConfig

def peak_mb():  # getrusage would include the memory of the parent process
    status = Path("/proc/self/status").read_text()
    return int(re.search(r"VmHWM:\\s+(\\d+)", status)[1]) / 1e3

crossing = Crossing(CrossingConfig(lighting="night", lead_s=2.0, step_px=8.0, max_step_ms=4.0))
peaks_mb = []
for sample in crossing.samples():
    peaks_mb.append(peak_mb())
before_entry = sum(us < 1.5e6 for us in crossing.times_us())
growth_mb = peaks_mb[before_entry - 1] - peaks_mb[50]
print(before_entry, len(peaks_mb), growth_mb, peaks_mb[-1])
"""


def measured() -> list[float]:
    """Samples until 0.5 s before the vehicle enters, all samples, growth until then, peak [MB]."""
    command = [sys.executable, "-c", MEASURE]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    return [float(word) for word in answer.stdout.split()]


def test_a_sequence_is_streamed_and_takes_less_than_a_gigabyte() -> None:
    before_entry, count, growth_mb, peak_mb = measured()
    assert before_entry > 300
    assert count > 2 * before_entry
    assert growth_mb < 0.1 * SAMPLE_MB * before_entry
    if peak_mb >= LIMIT_MB:  # the first process may have had to compile kernels
        *_, peak_mb = measured()
    assert peak_mb < LIMIT_MB


def test_glibc_accepts_the_thresholds() -> None:
    assert return_large_blocks() == (platform.libc_ver()[0] == "glibc")


def test_all_free_memory_is_requested_from_glibc(monkeypatch: pytest.MonkeyPatch) -> None:
    kept_bytes: list[int] = []
    library = SimpleNamespace(malloc_trim=kept_bytes.append)
    monkeypatch.setattr(ctypes, "CDLL", lambda _: library)
    return_free_memory()
    assert kept_bytes == [0]


def test_another_c_library_is_left_unchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
    return_free_memory()
    assert not return_large_blocks()
