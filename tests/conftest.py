"""Settings that all tests share."""

from collections.abc import Iterator

import pytest
from hypothesis import settings

settings.register_profile("flybench", deadline=None)  # the first call of a kernel compiles it
settings.load_profile("flybench")


@pytest.fixture(autouse=True, scope="session")
def _without_user_cache() -> Iterator[None]:
    """Keep the tests from reading or writing the user's luminance cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FLYBENCH_CACHE", "off")
        yield
