import sys
from pathlib import Path

import pytest

from scenarios.cli import main
from scenarios.errors import ScenarioError
from scenarios.options.repetition import refuse_repetition


@pytest.mark.parametrize(
    "arguments",
    [
        ["--method", "fly", "--method", "wide"],
        ["--method=fly", "--method", "wide"],
        ["--step-px", "8", "--step_px", "4"],
        ["--set", "a=1", "--method", "fly", "--out", "--out"],
    ],
)
def test_an_option_given_twice_is_refused(arguments: list[str]) -> None:
    with pytest.raises(ScenarioError, match=r"--[a-z-]+ is given 2 times; allowed is once"):
        refuse_repetition(arguments)


def test_once_is_allowed_and_several_where_all_count() -> None:
    refuse_repetition(["file", "--method", "fly", "--omegas", "1.0", "1.0", "-1", "-1"])
    refuse_repetition(["--set", "theta_on=0.2", "--set", "theta_off=0.2"])
    refuse_repetition(["--method", "fly", "--method", "wide"], also_several={"--method"})


def refusal_of(
    arguments: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> str:
    """What a command says that ends before it does anything."""
    monkeypatch.setattr(sys, "argv", ["flybench", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize("command", ["velocity-sweep", "run"])
def test_commands_refuse_a_second_method(
    command: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    said = refusal_of([command, "--method", "fly", "--method", "wide"], capsys, monkeypatch)
    assert "flybench: --method is given 2 times" in said
    assert not list(tmp_path.iterdir())


def test_envelope_takes_several_methods(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    said = refusal_of(["envelope", "--method", "fly", "--method", "nobody"], capsys, monkeypatch)
    assert "the method is 'nobody'" in said
