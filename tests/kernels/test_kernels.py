import os
from pathlib import Path

import emulator
import kernels
import sim
from kernels import compiled, discard_stale


def test_kernels_older_than_a_source_are_discarded(tmp_path: Path) -> None:
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    own_s = Path(kernels.__file__).stat().st_mtime
    times_s = {"a.py": 10, "b.py": 50, "__pycache__/old.nbi": 30, "__pycache__/new.nbi": 60}
    for name, later_s in times_s.items():
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (own_s + later_s, own_s + later_s))
    discard_stale(tmp_path)
    assert [index.name for index in cache.iterdir()] == ["new.nbi"]


def test_a_package_is_looked_at_when_it_compiles_its_first_kernel(tmp_path: Path) -> None:
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    source = tmp_path / "doubling.py"
    source.write_text("def doubled(x):\n    return 2 * x\n")
    (cache / "old.nbi").touch()
    os.utime(cache / "old.nbi", (1000, 1000))
    names: dict[str, object] = {}
    exec(compile(source.read_text(), str(source), "exec"), names)
    assert compiled(names["doubled"])(4) == 8  # type: ignore[type-var, operator]
    assert not (cache / "old.nbi").exists()


def test_every_kernel_of_light_and_sensor_is_compiled_alike() -> None:
    for package in (sim, emulator):
        sources = Path(package.__path__[0]).glob("*.py")
        assert not [path.name for path in sources if "njit" in path.read_text(encoding="utf-8")]
