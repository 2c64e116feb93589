"""Options that are given more than once."""

import sys
from pathlib import Path

import pytest

from scenarios.cli import main
from scenarios.errors import ScenarioError
from scenarios.output.repetition import check_repetition


@pytest.mark.parametrize(
    "arguments",
    [
        ["--method", "fly", "--method", "wide"],
        ["--method=fly", "--method", "wide"],
        ["--step-px", "8", "--step_px", "4"],
        ["--set", "a=1", "--method", "fly", "--out", "--out"],
    ],
)
def test_a_repeated_option_is_refused(arguments: list[str]) -> None:
    with pytest.raises(ScenarioError, match=r"--[a-z-]+ is given 2 times\. Allowed is one"):
        check_repetition(arguments)


def test_repeatable_options_and_values_may_be_repeated() -> None:
    check_repetition(["file", "--method", "fly", "--omegas", "1.0", "1.0", "-1", "-1"])
    check_repetition(["--set", "theta_on=0.2", "--set", "theta_off=0.2"])
    check_repetition(["--method", "fly", "--method", "wide"], also_repeatable={"--method"})


def error_of(
    arguments: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> str:
    """Return the error of a command that ends before it does anything."""
    monkeypatch.setattr(sys, "argv", ["flybench", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize("command", ["velocity-sweep", "run"])
def test_commands_refuse_two_methods(
    command: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    error = error_of([command, "--method", "fly", "--method", "wide"], capsys, monkeypatch)
    assert "flybench: --method is given 2 times" in error
    assert not list(tmp_path.iterdir())


def test_envelope_takes_several_methods(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    error = error_of(["envelope", "--method", "fly", "--method", "nobody"], capsys, monkeypatch)
    assert "The method is 'nobody'" in error
