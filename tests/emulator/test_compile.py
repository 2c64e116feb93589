import os
from pathlib import Path

from emulator._compile import discard_stale_kernels


def test_kernels_older_than_a_source_are_discarded(tmp_path: Path) -> None:
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    for name, age in (("noise.py", 100), ("pixel.py", 50)):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (1000 - age, 1000 - age))
    for name, age in (("old.nbi", 70), ("new.nbi", 20)):
        (cache / name).touch()
        os.utime(cache / name, (1000 - age, 1000 - age))
    discard_stale_kernels(tmp_path)
    assert [index.name for index in cache.iterdir()] == ["new.nbi"]
