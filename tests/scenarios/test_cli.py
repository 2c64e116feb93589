"""The command line as a whole: commands, their help, versions and completion."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from scenarios.cli import COMMANDS, GROUPS, command_class, main

ROOT = Path(__file__).parents[2]
HEAVY = ("mujoco", "rerun", "matplotlib", "numba", "pyarrow")


def printed(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> tuple[object, str]:
    monkeypatch.setattr(sys, "argv", ["flybench", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    shown = capsys.readouterr()
    return ended.value.code, shown.out + shown.err


def test_every_command_exists_and_has_one_sentence() -> None:
    for name in COMMANDS:
        text = command_class(name).__doc__
        assert text.endswith("."), name
        assert len(text) <= 62, name  # one line of the help


def test_every_command_is_in_one_group_of_the_help() -> None:
    assert sorted(" ".join(GROUPS.values()).split()) == sorted(COMMANDS)


@pytest.mark.parametrize("arguments", [[], ["--help"]])
def test_the_help_lists_every_command(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["flybench", *arguments])
    main()
    text = capsys.readouterr().out
    for name in COMMANDS:
        assert re.search(rf"^ {name} +[A-Z]", text, re.MULTILINE)
    assert "Make a film" in text
    assert max(map(len, text.splitlines())) <= 80


def test_a_misspelt_command_is_refused_with_the_list(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    status, text = printed(["rnu"], monkeypatch, capsys)
    assert status == 2
    assert "velocity-sweep" in text


def test_an_option_may_come_before_the_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    status, text = printed(["--quiet", "view", "nowhere"], monkeypatch, capsys)
    assert status == 2
    assert "There is no recording at nowhere" in text


def test_the_help_and_the_version_need_no_heavy_library() -> None:
    for arguments in ("--help", "--version"):
        script = (
            f"import sys; sys.argv = ['flybench', {arguments!r}]\n"
            "from flybench.__main__ import main\n"
            "try:\n    main()\nexcept SystemExit:\n    pass\n"
            f"print(sorted(set({HEAVY!r}) & set(sys.modules)))"
        )
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT, check=True
        )
        assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("name", COMMANDS)
def test_no_default_is_shown_as_python_writes_nothing(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    status, text = printed([name, "--help"], monkeypatch, capsys)
    words = " ".join(text.replace("│", " ").split())
    assert status == 0
    for nothing in ("(default: None)", "(default: )", "(default: ())"):
        assert nothing not in words


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_completion_of_a_shell_knows_commands_and_options(
    shell: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "completion"
    status, _ = printed(["--tyro-write-completion", shell, str(file)], monkeypatch, capsys)
    assert not status
    text = file.read_text()
    assert "velocity-sweep" in text
    assert "illuminance-lux" in text
