"""Every Python example in the documentation runs, and links between its files lead somewhere.

The tutorials and how-to pages build on each other; the site runs them when it is built.
"""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
READMES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *(ROOT / package / "README.md" for package in ("sim", "emulator", "detector", "formats")),
    ROOT / "scenarios" / "README.md",
]
PAGES = sorted(
    p for part in ("explanation", "reference") for p in (ROOT / "docs" / part).glob("*.md")
)
TESTED_ELSEWHERE = {"datasets.md", "emulator-python.md"}
"""Pages whose examples run in tests of their own."""
EXAMPLE = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)#:\s]+)(#[^)\s]+)?\)")
FILE = re.compile(
    r"`((?:tests|tools|sim|emulator|detector|formats|scenarios|flybench|examples|docs)/[\w/.-]+)`"
)
BUILT = ("docs/_build", "docs/auto_gallery")
"""What `make docs` makes."""
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)


def examples() -> list[tuple[str, str]]:
    found = []
    for page in READMES + PAGES:
        if page.name not in TESTED_ELSEWHERE:
            text = page.read_text(encoding="utf-8")
            name = page.relative_to(ROOT).as_posix()
            found += [(f"{name}:{k}", code) for k, code in enumerate(EXAMPLE.findall(text))]
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


def anchors(page: Path) -> set[str]:
    """Return the anchors that GitHub and the site make from the headings of a page."""
    titles = HEADING.findall(page.read_text(encoding="utf-8"))
    plain = (re.sub(r"[^\w\- ]", "", title.lower()) for title in titles)
    return {f"#{title.replace(' ', '-')}" for title in plain}


@pytest.mark.parametrize("page", READMES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_a_readme_links_to_what_exists(page: Path) -> None:
    """Sphinx checks the links of the site's own pages."""
    for path, anchor in LINK.findall(page.read_text(encoding="utf-8")):
        target = page.parent / path
        assert target.exists(), path
        if anchor and not path.endswith(".py"):
            assert anchor in anchors(target), f"{path}{anchor}"


def test_files_that_the_pages_name_exist() -> None:
    pages = READMES + sorted((ROOT / "docs").glob("*/*.md"))
    named = {file for page in pages for file in FILE.findall(page.read_text(encoding="utf-8"))}
    assert len(named) > 20
    real = {file for file in named if "NAME" not in file and not file.startswith(BUILT)}
    assert {file for file in real if not (ROOT / file).exists()} == set()
