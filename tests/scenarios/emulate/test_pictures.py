"""Open videos, and refuse what is none."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from scenarios.emulate.pictures import open_pictures
from scenarios.errors import ScenarioError
from tests.formats.sample_files import make_file, random_events


def test_a_relative_name_with_a_colon_is_a_video(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    video = tmp_path / "12:30 walk.avi"
    writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, (64, 48))
    for grey in (10, 20, 30):
        writer.write(np.full((48, 64, 3), grey, np.uint8))
    writer.release()
    monkeypatch.chdir(tmp_path)
    pictures = open_pictures(Path(video.name))
    assert [picture.shape for picture in pictures] == [(48, 64, 3)] * 3


@pytest.mark.parametrize("name", ["a.aedat4", "a.h5", "evt3.raw", "davis.aedat", "a.npz"])
def test_for_a_recording_of_events_the_error_names_flybench_detect(
    tmp_path: Path, name: str
) -> None:
    path = make_file(tmp_path, name, random_events())
    with pytest.raises(ScenarioError, match=r"recording of events, not a video.*flybench detect"):
        open_pictures(path)
