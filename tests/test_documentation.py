"""Every Python example in the documentation runs."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = (
    "docs/explanation/limits.md",
    "docs/explanation/real-recordings.md",
    "docs/explanation/realism.md",
    "docs/explanation/calibration.md",
    "README.md",
    "sim/README.md",
    "emulator/README.md",
    "detector/README.md",
    "formats/README.md",
    "scenarios/README.md",
)
MORE_PAGES = ("docs/explanation/datasets.md",)
"""Pages whose examples run in tests of their own."""
EXAMPLE = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def examples() -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        text = (ROOT / page).read_text(encoding="utf-8")
        found += [(f"{page}:{k}", code) for k, code in enumerate(EXAMPLE.findall(text))]
    return found


@pytest.mark.parametrize("code", [pytest.param(code, id=name) for name, code in examples()])
def test_an_example_runs(code: str, tmp_path: Path) -> None:
    script = tmp_path / "example.py"
    script.write_text(code, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-W", "error", str(script)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_the_pages_link_to_what_exists() -> None:
    for page in PAGES + MORE_PAGES:
        folder = (ROOT / page).parent
        links = re.findall(r"\]\(([^)#:]+)\)", (ROOT / page).read_text(encoding="utf-8"))
        missing = [link for link in links if not (folder / link).exists()]
        assert missing == [], page
