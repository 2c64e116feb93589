"""What all tests share."""

from collections.abc import Iterator

import pytest
from hypothesis import settings

settings.register_profile("flybench", deadline=None)  # a first call may compile
settings.load_profile("flybench")


@pytest.fixture(autouse=True, scope="session")
def _keep_no_light() -> Iterator[None]:
    """No test finds, or leaves, light in the user's own cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FLYBENCH_CACHE", "off")
        yield
