"""Films as files: MP4 and GIF hold what was added."""

from pathlib import Path

import av
import numpy as np
import pytest

from scenarios.errors import OutputError, ScenarioError
from scenarios.film import film_file
from scenarios.film.film_file import FilmFile
from scenarios.output.colours import OFF, ON


def images() -> list[np.ndarray]:
    image = np.full((51, 80, 3), 255, np.uint8)
    image[:, 40:] = ON
    other = image.copy()
    other[:, 40:] = OFF
    return [image, other, image]


@pytest.mark.parametrize(("ending", "error"), [(".mp4", 12), (".gif", 1)])
def test_a_film_holds_its_images(tmp_path: Path, ending: str, error: int) -> None:
    path = tmp_path / f"film{ending}"
    with FilmFile(path, fps=20) as film:
        for image in images():
            film.add(image)
    with av.open(str(path)) as container:
        found = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
        seconds = (container.duration or 0) / 1e6
    assert [image.shape for image in found] == [(52, 80, 3)] * 3
    assert seconds == pytest.approx(0.15, abs=0.01)
    for image, wanted in zip(found, images(), strict=True):
        middle = image[25, [10, 70]].astype(int)
        assert abs(middle - wanted[25, [10, 70]]).max() <= error


def test_a_larger_image_is_refused(tmp_path: Path) -> None:
    with FilmFile(tmp_path / "film.gif", fps=20) as film:
        film.add(images()[0])
        with pytest.raises(ScenarioError, match="sensors of different sizes"):
            film.add(np.zeros((60, 80, 3), np.uint8))


def test_without_pyav_the_error_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    with pytest.raises(OutputError, match=r"PyAV.*flybench\[all\]"):
        film_file.FilmFile(tmp_path / "film.gif", fps=20)
