"""The tutorials and how-to pages: their commands exist, and what is cheap runs as written.

Pages with `{code-cell}` blocks, the notebooks and the gallery run when the site is built.
"""

import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from scenarios.output import terminal
from tests.scenarios.in_process import exit_status

DOCS = Path(__file__).parent.parent / "docs"
FOLDERS = ("tutorials", "how-to", "notebooks")
PAGES = [DOCS / "index.md"]
PAGES += sorted(page for part in FOLDERS for page in (DOCS / part).glob("*.md"))
CHEAP = (
    "tutorials/your-own-recording.md",
    "how-to/emulate-my-video.md",
    "how-to/only-the-emulator.md",
    "how-to/camera-on-my-robot.md",
    "how-to/in-a-notebook.md",
)
"""Pages whose Python runs in seconds, without the result of a command."""
PYTHON = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
FILE = re.compile(
    r"^```\{code-block\} \w+\n:caption: (\S+)\n\n(.*?)^```$", re.DOTALL | re.MULTILINE
)
SHELL = re.compile(r"^```sh\n(.*?)^```$", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"`(flybench [a-z][^`]*)`")


def name_of(page: Path) -> str:
    return page.relative_to(DOCS).as_posix()


def commands(page: Path) -> Iterator[list[str]]:
    """Yield the arguments of every `flybench` command of a page, in blocks and in the text."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    lines = [line for block in SHELL.findall(text) for line in block.splitlines()]
    for line in lines + [found.replace("\n", " ") for found in INLINE.findall(text)]:
        words = shlex.split(line, comments=True)
        if words and words[0] == "flybench" and len(words) > 2:
            yield words[1:]


def runs(words: list[str]) -> bool:
    return bool(exit_status(words) == 0)


@pytest.fixture
def accepts(monkeypatch: pytest.MonkeyPatch) -> Callable[[list[str]], bool]:
    """Like `runs`, but only the arguments are parsed."""
    monkeypatch.setattr(terminal, "execute", lambda _command: 0)
    return runs


def test_a_wrong_option_is_not_accepted(accepts: Callable[[list[str]], bool]) -> None:
    assert accepts(["run", "--lighting", "night"])
    assert not accepts(["run", "--lightning", "night"])


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_a_page_gives_only_commands_that_exist(
    page: Path, accepts: Callable[[list[str]], bool]
) -> None:
    assert [shlex.join(words) for words in commands(page) if not accepts(words)] == []


@pytest.mark.parametrize("name", CHEAP)
def test_the_python_of_a_page_runs_as_written(name: str, tmp_path: Path) -> None:
    text = (DOCS / name).read_text(encoding="utf-8")
    for file, body in FILE.findall(text):
        (tmp_path / file).write_text(body, encoding="utf-8")
    made = [tmp_path / file for file, _ in FILE.findall(text) if file.endswith(".py")]
    for k, body in enumerate(PYTHON.findall(text)):
        made.append(tmp_path / f"block_{k}.py")
        made[-1].write_text(body, encoding="utf-8")
    assert made
    for script in made:
        done = subprocess.run(
            [sys.executable, "-W", "error", str(script)],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode == 0, f"{script.name}: {done.stderr}"


@pytest.mark.parametrize(
    ("command", "page"),
    [
        ("sweep", "tutorials/sweeps.md"),
        ("sweep", "how-to/sweep-and-plot.md"),
        ("dataset", "tutorials/datasets.md"),
        ("dataset", "how-to/labelled-dataset.md"),
    ],
)
def test_the_file_of_a_page_is_accepted(command: str, page: str, tmp_path: Path) -> None:
    name, body = FILE.findall((DOCS / page).read_text(encoding="utf-8"))[0]
    (tmp_path / name).write_text(body, encoding="utf-8")
    assert runs([command, str(tmp_path / name), "--dry-run"])


def test_every_page_is_in_a_list() -> None:
    for page in PAGES:
        if page.stem != "index":
            listed = (page.parent / "index.md").read_text(encoding="utf-8").splitlines()
            assert page.stem in listed, name_of(page)
