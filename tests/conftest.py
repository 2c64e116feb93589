"""What all tests share."""

from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True, scope="session")
def _keep_no_light() -> Iterator[None]:
    """No test finds, or leaves, light in the user's own cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FLYBENCH_CACHE", "off")
        yield
