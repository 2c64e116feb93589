"""Files of recordings: beside the manifest, in a folder, or fetched into the cache."""

import hashlib
import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from scenarios.validate.files import CACHE_FOLDER, find_file
from scenarios.validate.keys import ManifestError
from scenarios.validate.manifest import Manifest, Recording

CONTENT = b"events" * 1000
SHA = hashlib.sha256(CONTENT).hexdigest()


class QuietHandler(SimpleHTTPRequestHandler):
    """Serves files and prints nothing."""

    def log_message(self, *_: object) -> None:
        """Print nothing."""


@pytest.fixture
def server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Address of a server on this machine that serves `a.raw`."""
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    folder = tmp_path / "served"
    folder.mkdir()
    (folder / "a.raw").write_bytes(CONTENT)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(QuietHandler, directory=folder)) as http:
        threading.Thread(target=http.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{http.server_port}"
        http.shutdown()


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("FLYBENCH_CACHE", str(folder))
    return folder


def recording(file: str, *, url: str | None = None, sha256: str = SHA) -> Recording:
    return Recording("made", file, sha256, "CC0", "zenodo.org/1", (), url=url)


def find(tmp_path: Path, what: Recording, folder: Path | None = None) -> Path:
    seen: list[tuple[int, int]] = []

    def progress(label: str) -> Callable[[int, int], None]:
        assert "made" in label
        return lambda done, total: seen.append((done, total))

    path = find_file(Manifest(tmp_path / "m.toml", (what,)), what, folder, progress)
    assert seen == [] or seen[-1] == (len(CONTENT), len(CONTENT))
    return path


def test_a_file_is_fetched_once_and_kept_in_the_cache(
    server: str, cache: Path, tmp_path: Path
) -> None:
    url = f"{server}/a.raw"
    path = find(tmp_path, recording("kept.raw", url=url))
    assert path.read_bytes() == CONTENT
    assert path.parent.parent == cache / CACHE_FOLDER
    assert path.name == "kept.raw"
    (tmp_path / "served" / "a.raw").unlink()
    assert find(tmp_path, recording("kept.raw", url=url)) == path


def test_a_damaged_file_in_the_cache_is_fetched_again(
    server: str, cache: Path, tmp_path: Path
) -> None:
    what = recording("kept.raw", url=f"{server}/a.raw")
    find(tmp_path, what).write_bytes(b"damaged")
    assert find(tmp_path, what).read_bytes() == CONTENT


def test_a_fetched_file_with_another_content_is_refused_and_not_kept(
    server: str, cache: Path, tmp_path: Path
) -> None:
    with pytest.raises(ManifestError, match=r"cannot be fetched from .*hash.*--folder DIR"):
        find(tmp_path, recording("a.raw", url=f"{server}/a.raw", sha256="0" * 64))
    assert [path for path in cache.rglob("*") if path.is_file()] == []


def test_an_address_without_the_file_or_server_is_named(
    server: str, cache: Path, tmp_path: Path
) -> None:
    for url in (f"{server}/b.raw", "http://127.0.0.1:1/b.raw"):
        with pytest.raises(ManifestError) as caught:
            find(tmp_path, recording("b.raw", url=url))
        assert f"cannot be fetched from {url}: " in str(caught.value)
        assert "\n" not in str(caught.value)


def test_without_a_cache_the_message_names_the_folder_option(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("FLYBENCH_CACHE", "off")
    with pytest.raises(ManifestError, match=r"FLYBENCH_CACHE is off.*--folder DIR"):
        find(tmp_path, recording("a.raw", url="http://127.0.0.1:1/a.raw"))


def test_a_folder_is_used_instead_of_address_and_path(tmp_path: Path) -> None:
    (tmp_path / "a.raw").write_bytes(CONTENT)
    for what in (recording("a.raw", url="http://127.0.0.1:1/x"), recording("deep/a.raw")):
        assert find(tmp_path, what, tmp_path) == tmp_path / "a.raw"


def test_without_an_address_the_path_is_relative_to_the_manifest(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "a.raw").write_bytes(CONTENT)
    assert find(tmp_path, recording("deep/a.raw")) == tmp_path / "deep" / "a.raw"
    with pytest.raises(ManifestError, match=r"b\.raw, does not exist. Get it from zenodo.org/1"):
        find(tmp_path, recording("b.raw"))


def test_another_content_is_refused_with_both_sums(tmp_path: Path) -> None:
    (tmp_path / "a.raw").write_bytes(b"other")
    other = hashlib.sha256(b"other").hexdigest()
    with pytest.raises(ManifestError, match=f"sha256 of made is {SHA}, and .* has {other}"):
        find(tmp_path, recording("a.raw"))
