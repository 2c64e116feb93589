"""Settings that all tests share."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("flybench", deadline=None)  # the first call of a kernel compiles it
settings.load_profile("flybench")

TESTS = Path(__file__).parent
FIRST = (
    "scenarios/calibrate/test_calibration.py",  # compiles the sensor
    "sim/cache/test_luminance_cache.py",  # compiles the scene
    "end_to_end/test_directions.py",
    "repeatability/test_repeatability.py",
    "emulator/characterisation/experiments/test_arbiter.py",
    "scenarios/convergence/test_measure.py",
    "scenarios/velocity_sweep/test_grms.py",
    "end_to_end/test_run_command.py",
    "scenarios/dataset/test_dataset.py",
    "scenarios/options/test_cache.py",
    "test_documentation.py",
    "test_guides.py",
    "scenarios/test_guests.py",
)
"""Files that take longest, so that no process waits for another at the end. A process compiles
every kernel that no other has stored, so the first two begin with different packages."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Start with the files of `FIRST`; `--no-loadscope-reorder` keeps this order in parallel."""
    places = {(TESTS / name).resolve(strict=True): n for n, name in enumerate(FIRST)}
    items.sort(key=lambda item: places.get(item.path, len(FIRST)))


@pytest.fixture(autouse=True, scope="session")
def _without_user_cache() -> Iterator[None]:
    """Keep the tests from reading or writing the user's luminance cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FLYBENCH_CACHE", "off")
        yield
