"""The log of a command: in a file, and with --verbose on the terminal."""

import logging
from contextlib import suppress
from pathlib import Path

import pytest

from formats import FormatError
from scenarios.errors import OutputError, ScenarioError
from scenarios.output import log
from scenarios.output.arguments.shared_options import SharedOptions
from scenarios.output.log import log_step
from scenarios.output.streams import complain, say
from scenarios.output.terminal import execute


class Fails:
    def execute(self) -> int:
        log_step("opening\x1b[2J the file")
        say("first line")
        complain("warning: a warning")
        raise FormatError("a.raw is truncated. Copy it again.")


def test_a_log_file_has_what_a_command_does_and_prints(tmp_path: Path) -> None:
    log = tmp_path / "run.log"
    log.write_text("before\n", encoding="utf-8")
    with SharedOptions(log=log).applied():
        assert execute(Fails()) == 2
        logging.getLogger("flybench").warning("from a package")
    log_step("too late")
    text = log.read_text(encoding="utf-8")
    assert text.startswith("before\n")
    for words in (
        "INFO flybench ",
        "INFO opening\\x1b[2J the file",
        "DEBUG first line",
        "WARNING warning: a warning",
        "WARNING a.raw is truncated",
        "in execute",  # of the traceback
        "INFO status 2 after",
        "WARNING from a package",
    ):
        assert words in text
    assert "too late" not in text


def test_an_unexpected_error_is_in_the_log(tmp_path: Path) -> None:
    class Broken:
        def execute(self) -> int:
            raise ZeroDivisionError("of ours")

    with SharedOptions(log=tmp_path / "a.log").applied(), pytest.raises(ZeroDivisionError):
        execute(Broken())
    assert "ZeroDivisionError: of ours" in (tmp_path / "a.log").read_text(encoding="utf-8")


def test_verbose_prints_what_a_command_does(capsys: pytest.CaptureFixture[str]) -> None:
    with SharedOptions(verbose=True).applied():
        execute(Fails())
    printed = capsys.readouterr().err
    assert "flybench: opening\\x1b[2J the file" in printed
    assert "FormatError" in printed
    assert printed.count("warning: a warning") == 1


def test_without_options_only_complaints_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with SharedOptions().applied():
        execute(Fails())
    assert capsys.readouterr().err.splitlines() == [
        "flybench: warning: a warning",
        "flybench: a.raw is truncated. Copy it again.",
    ]


def test_a_log_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"--log .* cannot be written"):
        SharedOptions(log=tmp_path / "missing" / "a.log").applied().__enter__()


def test_a_full_disk_is_said_once(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log, "_opened", lambda path: path.open("w", encoding="utf-8"))
    with suppress(OSError), SharedOptions(log=Path("/dev/full")).applied():
        log_step("one")
        log_step("two")
    assert capsys.readouterr().err.count("the log file cannot be written (") == 1


def test_verbose_and_quiet_exclude_each_other() -> None:
    with pytest.raises(ScenarioError, match="--verbose and --quiet"):
        SharedOptions(verbose=True, quiet=True).applied().__enter__()
