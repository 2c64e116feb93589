"""The start of the command, before its libraries are loaded."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STARTED = """
import signal, sys
from flybench.__main__ import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in a shell's background
print("started", flush=True)
sys.argv = ["flybench", "doctor", "--help"]
main()
"""


@pytest.mark.parametrize("after_s", [0.0, 0.3, 1.0])
def test_ctrl_c_while_the_libraries_load_gives_one_line(after_s: float) -> None:
    command = [sys.executable, "-c", STARTED]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, cwd=ROOT) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == b"started\n"
        time.sleep(0.02 + after_s)
        process.send_signal(signal.SIGINT)
        error = process.stderr.read()
        interrupted = (130, b"flybench: interrupted\n")
        ended = [(0, b""), (-signal.SIGINT, b"")]  # before the signal, or while Python ended
        allowed = [interrupted, *ended] if after_s else [interrupted]
        assert (process.wait(), error) in allowed


def test_ctrl_c_removes_the_folder_of_matplotlib(tmp_path: Path) -> None:
    script = (
        "import os, signal\nimport flybench.__main__ as m\nfrom pathlib import Path\n"
        "m._give_matplotlib_a_folder()\nprint(os.environ['MPLCONFIGDIR'], flush=True)\n"
        "signal.signal(signal.SIGINT, m._end)\nos.kill(os.getpid(), signal.SIGINT)\n"
    )
    environment = {name: value for name, value in os.environ.items() if name != "MPLCONFIGDIR"}
    environment |= {"HOME": str(tmp_path / "missing"), "TMPDIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, env=environment, cwd=ROOT
    )
    assert done.returncode == 130
    assert done.stdout.startswith(str(tmp_path / "flybench-"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["sim.py", "formats/__init__.py"])
def test_a_users_file_that_hides_a_package_is_named(tmp_path: Path, name: str) -> None:
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).touch()
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "flybench", "doctor"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert done.returncode == 1
    assert f"{tmp_path / name} hides the package {Path(name).parts[0].removesuffix('.py')}" in (
        done.stderr
    )
    assert len(done.stderr.splitlines()) == 1


def test_a_users_folder_without_init_hides_nothing(tmp_path: Path) -> None:
    (tmp_path / "detector").mkdir()
    (tmp_path / "detector" / "mine.py").touch()
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "flybench", "--help"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert done.returncode == 0
