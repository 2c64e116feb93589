"""Full disks."""

import errno
from pathlib import Path

import pytest

from flybench.disk_space import caused_by_full_disk, check_free_space
from flybench.errors import FlybenchError


def test_too_little_free_space_is_named_with_what_is_needed(tmp_path: Path) -> None:
    check_free_space(tmp_path / "not" / "yet", 1, FlybenchError)
    with pytest.raises(FlybenchError, match=rf"disk of {tmp_path} has .* about 2,000,000\.0 MB"):
        check_free_space(tmp_path, 2 * 10**12, FlybenchError)


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG])
def test_a_full_disk_is_recognised_through_other_errors(number: int) -> None:
    wrapped = FlybenchError("cannot be written")
    wrapped.__cause__ = OSError(number, "full")
    assert caused_by_full_disk(wrapped)
    assert caused_by_full_disk(RuntimeError(f"failed to write (os error {number})"))
    assert not caused_by_full_disk(OSError(errno.EACCES, "denied"))
    assert not caused_by_full_disk(None)
