"""`flybench view`: what it opens, and its errors."""

import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rerun import RecordingStream, TextLog

from scenarios.commands import view
from scenarios.errors import ScenarioError
from scenarios.output.atomic_folder import RECORDING
from scenarios.recording import viewer_process
from scenarios.recording.viewer_process import free_port, is_free


@pytest.fixture
def study(tmp_path: Path) -> Path:
    folder = tmp_path / view.RECORDINGS
    folder.mkdir()
    for name in ("night_1.07", "day_2.42", "day_1.21"):
        (folder / f"{name}.rrd").write_bytes(view.MAGIC)
    (folder / "notes.txt").touch()
    return tmp_path


@pytest.mark.parametrize("name", ["missing", "missing.rrd", "notes.txt", "empty.rrd"])
def test_other_files_are_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "notes.txt").write_text("")
    (tmp_path / "empty.rrd").touch()
    with pytest.raises(ScenarioError, match="There is no recording at"):
        view.find_recordings(tmp_path / name)


def test_a_run_has_one_recording(tmp_path: Path) -> None:
    recording = tmp_path / RECORDING
    recording.write_bytes(view.MAGIC)
    assert view.find_recordings(tmp_path) == [recording]
    assert view.find_recordings(recording) == [recording]


def test_all_recordings_of_a_study_are_opened_in_order(study: Path) -> None:
    found = view.find_recordings(study)
    assert [path.stem for path in found] == ["day_1.21", "day_2.42", "night_1.07"]


def test_one_recording_of_a_study_is_opened_by_name(study: Path) -> None:
    assert [path.stem for path in view.find_recordings(study, "night_1.07")] == ["night_1.07"]


def test_the_error_for_an_unknown_name_lists_the_recordings(study: Path) -> None:
    with pytest.raises(ScenarioError, match=r"is day_3\. Allowed in .* is day_1\.21, day_2\.42"):
        view.find_recordings(study, "day_3")
    with pytest.raises(ScenarioError, match="has no recordings of a study"):
        view.find_recordings(study / "elsewhere", "day_3")


def test_one_local_viewer_opens_all_recordings(
    monkeypatch: pytest.MonkeyPatch, study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    called: list[list[str]] = []

    def call(command: list[str], **_: object) -> int:
        called.append(command)
        return 0

    monkeypatch.setattr(subprocess, "call", call)
    assert view.View(study, web=True, port=free_port()).execute() == 0
    ((program, *files, bind, address, _, data, web, _, page),) = called
    assert Path(program).name == "rerun"
    assert [Path(file).stem for file in files] == ["day_1.21", "day_2.42", "night_1.07"]
    assert (bind, address, web) == ("--bind", "127.0.0.1", "--serve-web")
    first, second, _ = capsys.readouterr().out.splitlines()
    proxy = f"rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{data}%2Fproxy"
    assert first == f"Open http://127.0.0.1:{page}?url={proxy} in a browser."
    assert f"ssh -L {page}:127.0.0.1:{page} -L {data}:127.0.0.1:{data} " in second


def test_two_windows_have_different_ports(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        used = other.getsockname()[1]
        monkeypatch.setattr(view, "DATA_PORT", used)
        page, data = view.View(Path())._ports()
    assert (page, data != used) == (None, True)


def test_a_viewer_that_fails_is_named(
    monkeypatch: pytest.MonkeyPatch, study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(subprocess, "call", lambda *_, **__: 3)
    assert view.View(study, web=True).execute() == 3
    assert "The viewer ended with status 3" in capsys.readouterr().err


def test_the_page_and_the_data_have_different_ports(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(view, "is_free", lambda _: True)
    monkeypatch.setattr(viewer_process, "is_free", lambda _: True)
    page, data = view.View(Path(), web=True, port=view.DATA_PORT)._ports()
    assert (page, data != page) == (view.DATA_PORT, True)
    assert view.View(Path(), web=True)._ports() == (9090, 9876)


def test_a_picture_shows_the_chosen_recording(
    monkeypatch: pytest.MonkeyPatch, study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shown: list[Path] = []

    def screenshot(path: Path, png: Path, **_: object) -> None:
        shown.append(path)
        png.write_text("picture")

    monkeypatch.setattr(view, "screenshot", screenshot)
    png = study / "a.png"
    assert view.View(study, screenshot=png).execute() == 0
    with pytest.raises(ScenarioError, match=r"a\.png exists already\. Allowed is a new file"):
        view.View(study, screenshot=png).execute()
    again = view.View(study, recording="day_2.42", screenshot=png, overwrite=True)
    assert again.execute() == 0
    assert [path.stem for path in shown] == ["day_1.21", "day_2.42"]
    assert "day_2.42.rrd" in capsys.readouterr().out


def test_a_picture_must_be_a_png(study: Path) -> None:
    with pytest.raises(ScenarioError, match=r"--screenshot is a\.jpg\. Allowed .* ends in \.png"):
        view.View(study, screenshot=Path("a.jpg")).execute()


def test_the_error_without_a_display_names_the_alternatives(
    monkeypatch: pytest.MonkeyPatch, study: Path
) -> None:
    monkeypatch.setattr(view, "has_display", lambda: False)
    with pytest.raises(ScenarioError, match="--web"):
        view.View(study).execute()


def test_a_port_in_use_is_refused_or_another_is_taken(
    monkeypatch: pytest.MonkeyPatch, study: Path
) -> None:
    called: list[list[str]] = []

    def call(command: list[str], **_: object) -> int:
        called.append(command)
        return 0

    monkeypatch.setattr(subprocess, "call", call)
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(ScenarioError, match=rf"--port is {port}, which is in use, .* another"):
            view.View(study, web=True, port=port).execute()
        monkeypatch.setattr(view, "WEB_PORT", port)
        assert view.View(study, web=True).execute() == 0
    ((*_, data, _, web, page),) = called
    assert (web, page.isdecimal(), data.isdecimal()) == ("--web-viewer-port", True, True)
    assert page != str(port)


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_a_port_out_of_range_is_refused(study: Path, port: int) -> None:
    with pytest.raises(ScenarioError, match=rf"--port is {port}\. Allowed is .* from 1 to 65535"):
        view.View(study, web=True, port=port).execute()


def test_a_port_without_the_web_is_refused(monkeypatch: pytest.MonkeyPatch, study: Path) -> None:
    monkeypatch.setattr(view, "has_display", lambda: True)
    with pytest.raises(ScenarioError, match=r"--port is 9091 without --web\. Allowed"):
        view.View(study, port=9091).execute()


def wait_until_free(port: int, expected: bool) -> None:
    end_s = time.monotonic() + 30
    while is_free(port) is not expected:
        assert time.monotonic() < end_s
        time.sleep(0.05)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs prctl")
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_the_viewer_ends_with_the_command(how: signal.Signals, tmp_path: Path) -> None:
    recording, port = tmp_path / RECORDING, free_port()
    with RecordingStream("test") as stream:
        stream.save(recording)
        stream.log("text", TextLog("hello"))
    command = [sys.executable, "-m", "scenarios.commands.view", str(recording), "--web"]
    with subprocess.Popen([*command, "--port", str(port)], stderr=subprocess.DEVNULL) as process:
        wait_until_free(port, expected=False)
        process.send_signal(how)
        process.wait()
    wait_until_free(port, expected=True)
