"""Read MATLAB files of versions 5 and 7.3."""

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from formats import FormatError, open_events, read_events
from formats.columns import ReadOptions
from formats.readers import matlab
from tests.formats.sample_files import make_file, matlab_structure, random_events

E = random_events(2000)
TD = matlab_structure(E)


def save_5(path: Path, **variables: object) -> Path:
    scipy.io.savemat(path, variables, appendmat=False)
    return path


def save_73(path: Path, **variables: Any) -> Path:
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in variables.items():
            fields = value if isinstance(value, dict) else {"": value}
            for field, values in fields.items():
                file[f"{name}/{field}".rstrip("/")] = np.reshape(values, (1, -1))
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\x02IM")
    return path


SAVE = pytest.mark.parametrize("save", [save_5, save_73])
Save = Callable[..., Path]


@pytest.mark.parametrize("name", ["5.mat", "73.mat"])
def test_coordinates_from_1_are_converted_and_the_header_says_so(tmp_path: Path, name: str) -> None:
    with open_events(make_file(tmp_path, name, E)) as file:
        got = np.concatenate([chunk.events for chunk in file])
    assert np.array_equal(got, E)
    assert (file.width, file.height, file.size_source) == (346, 260, "the events")
    assert file.header_fields["events in"] == "TD"
    assert file.header_fields["coordinates"] == "from 1, converted to from 0"
    assert file.header_fields["time unit"] == "µs, because the times are whole numbers"
    assert file.header_fields["version"] == {"5.mat": "5", "73.mat": "7.3"}[name]


@SAVE
def test_a_coordinate_of_0_means_that_they_count_from_0(tmp_path: Path, save: Save) -> None:
    structure = TD | {"x": E["x"].astype(np.uint16), "y": E["y"] + 0.0}
    path = save(tmp_path / "a.mat", TD=structure)
    assert np.array_equal(read_events(path, size=(346, 260)), E)
    with open_events(path) as file:
        assert file.header_fields["coordinates"] == "from 0"


@SAVE
def test_polarity_1_and_2_is_off_and_on(tmp_path: Path, save: Save) -> None:
    path = save(tmp_path / "a.mat", TD=TD | {"p": E["p"] + 1.0})
    assert np.array_equal(read_events(path, size=(346, 260)), E)


@SAVE
def test_polarity_that_is_1_everywhere_is_on(tmp_path: Path, save: Save) -> None:
    path = save(tmp_path / "a.mat", TD=TD | {"p": np.ones(E.size)})
    assert read_events(path, size=(346, 260))["p"].all()


@SAVE
def test_variables_without_a_structure(tmp_path: Path, save: Save) -> None:
    path = save(tmp_path / "a.mat", note=np.ones(3), **TD)
    with open_events(path, size=(346, 260)) as file:
        assert file.header_fields["events in"] == "variables"
        assert np.array_equal(np.concatenate([chunk.events for chunk in file]), E)


@SAVE
def test_td_comes_before_other_structures(tmp_path: Path, save: Save) -> None:
    other = {name: values[:5] for name, values in TD.items()}
    path = save(tmp_path / "a.mat", A=other, TD=TD)
    with open_events(path) as file:
        assert file.header_fields["not read"] == "A"
        assert sum(chunk.events.size for chunk in file) == E.size


def test_a_structure_within_structures(tmp_path: Path) -> None:
    polarity = {"timeStamp": E["t"].astype(np.int32), "x": E["x"], "y": E["y"], "polarity": E["p"]}
    path = save_5(tmp_path / "a.mat", aedat={"data": {"polarity": polarity}, "info": {"x": 1}})
    with open_events(path) as file:
        assert file.header_fields["events in"] == "aedat.data.polarity"
        assert np.array_equal(np.concatenate([chunk.events for chunk in file]), E)


@SAVE
def test_times_with_decimals_are_seconds(tmp_path: Path, save: Save) -> None:
    path = save(tmp_path / "a.mat", TD=TD | {"ts": E["t"] / 1e6})
    assert np.array_equal(read_events(path, size=(346, 260)), E)
    path = save(tmp_path / "b.mat", TD=TD | {"ts": np.floor(E["t"] / 1000)})
    assert np.array_equal(read_events(path, time_unit="ms")["t"], E["t"] // 1000 * 1000)


@SAVE
def test_unequal_columns_and_missing_columns_are_refused(tmp_path: Path, save: Save) -> None:
    with pytest.raises(FormatError, match=r"2000 t, 3 x, 2000 y, 2000 p in TD"):
        read_events(save(tmp_path / "a.mat", TD=TD | {"x": np.ones(3)}))
    with pytest.raises(FormatError, match="no events that could be found"):
        read_events(save(tmp_path / "b.mat", data=np.ones(9)))


def test_an_incomplete_data_set_is_refused(tmp_path: Path) -> None:
    with h5py.File(save_73(tmp_path / "a.mat", TD=TD), "r+") as file:
        del file["TD/x"]
        file.create_dataset("TD/x", (1, 10**12), "f8", chunks=(1, 1000))
    with pytest.raises(FormatError, match="should contain 1000000000000 values in /TD/x"):
        read_events(tmp_path / "a.mat")


def test_links_to_other_files_are_not_followed(tmp_path: Path) -> None:
    save_73(tmp_path / "secret.mat", TD=TD)
    with h5py.File(save_73(tmp_path / "a.mat", other=np.ones(3)), "r+") as file:
        for name in TD:
            file[f"TD/{name}"] = h5py.ExternalLink("secret.mat", f"/TD/{name}")
    with pytest.raises(FormatError, match=r"/TD/\w+ is a link to another file"):
        read_events(tmp_path / "a.mat")


def test_version_5_that_does_not_fit_into_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def load(*_: object, **__: object) -> None:
        raise MemoryError("Unable to allocate 2.00 GiB")

    path = save_5(tmp_path / "a.mat", TD=TD)
    monkeypatch.setattr(scipy.io, "loadmat", load)
    with pytest.raises(FormatError, match=r"a.mat does not fit into .* Save it with -v7.3"):
        matlab.read(path, ReadOptions())


def test_a_zip_of_text_is_to_be_unpacked_first(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("events.txt", "0.1 1 2 1\n")
        archive.writestr("images/0.png", "")
    with pytest.raises(FormatError, match=r"zip archive of events.txt and 1 more.*Unpack it first"):
        read_events(tmp_path / "a.zip")


@pytest.mark.parametrize(
    ("head", "tool"), [(b"BZh91AY", "bunzip2"), (b"\x28\xb5\x2f\xfd\0", "unzstd")]
)
def test_compressed_files_are_to_be_unpacked_first(tmp_path: Path, head: bytes, tool: str) -> None:
    (tmp_path / "a.bag").write_bytes(head)
    with pytest.raises(FormatError, match=f"Unpack it with {tool} first"):
        read_events(tmp_path / "a.bag")
