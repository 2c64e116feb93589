"""The documented example of a sensor runs in a process that cannot import the renderer."""

import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "emulator-python.md"
EXAMPLE, *_ = re.findall(
    r"^```python\n(.*?)^```$", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE
)


def test_the_example_runs_without_the_renderer() -> None:
    code = f"import sys\nsys.modules['mujoco'] = None\n{EXAMPLE}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) >= 10
    assert "frame of" in lines[0]
    assert "events in the last step, 0 lost in the readout" in lines[-1]
    assert int(lines[-1].split()[0]) > 0


def test_the_example_is_short() -> None:
    assert len(EXAMPLE.splitlines()) <= 20
