import os
from pathlib import Path

import sim
from sim._compile import discard_stale_kernels


def test_kernels_older_than_a_source_are_discarded(tmp_path: Path) -> None:
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    for path, age in (("a.py", 100), ("b.py", 50), ("__pycache__/old.nbi", 70)):
        (tmp_path / path).touch()
        os.utime(tmp_path / path, (1000 - age, 1000 - age))
    (cache / "new.nbi").touch()
    discard_stale_kernels(tmp_path)
    assert [index.name for index in cache.iterdir()] == ["new.nbi"]


def test_every_kernel_is_compiled_alike() -> None:
    sources = Path(sim.__path__[0]).glob("*.py")
    using = {path.name for path in sources if "njit" in path.read_text(encoding="utf-8")}
    assert using == {"_compile.py"}
