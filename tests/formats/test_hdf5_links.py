"""HDF5 files that refer to other files, in every way that the library knows."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from formats import FormatError, read_events

COUNT = 3


def write_columns(group: Any, names: str = "txyp") -> None:
    for name in names:
        group[name] = np.ones(COUNT, np.uint8)


def external_link(file: Any, secret: Path) -> None:
    write_columns(file.create_group("events"), "typ")
    file["events/x"] = h5py.ExternalLink(str(secret), "/x")


def external_group(file: Any, secret: Path) -> None:
    file["events"] = h5py.ExternalLink(str(secret), "/")


def soft_link_through_external_link(file: Any, secret: Path) -> None:
    write_columns(file.create_group("events"), "typ")
    file["events/x"] = h5py.SoftLink("/zz/x")
    file.create_group("more")["out"] = h5py.ExternalLink(str(secret), "/")
    file["zz"] = h5py.SoftLink("more/out")


def external_storage(file: Any, secret: Path) -> None:
    write_columns(file.create_group("events"), "typ")
    external = [(str(secret), 0, COUNT)]
    file["events"].create_dataset("x", (COUNT,), np.uint8, external=external)


def virtual(file: Any, secret: Path) -> None:
    write_columns(file.create_group("events"), "typ")
    layout = h5py.VirtualLayout((COUNT,), np.uint8)
    layout[:] = h5py.VirtualSource(str(secret), "x", (COUNT,))
    file["events"].create_virtual_dataset("x", layout)


def offset(file: Any, secret: Path) -> None:
    write_columns(file.create_group("events"))
    file["t_offset"] = h5py.ExternalLink(str(secret), "/x")


def resolution(file: Any, secret: Path) -> None:
    group = file.create_group("events")
    write_columns(group)
    group.create_group("calib")["resolution"] = h5py.ExternalLink(str(secret), "/x")


def table(file: Any, secret: Path) -> None:
    file.create_dataset("events", (1, 4), np.uint8, external=[(str(secret), 0, 4)])


@pytest.mark.parametrize(
    "write",
    [
        external_link,
        external_group,
        soft_link_through_external_link,
        external_storage,
        virtual,
        offset,
        resolution,
        table,
    ],
)
def test_no_other_file_is_read(tmp_path: Path, write: Callable[[Any, Path], None]) -> None:
    secret, path = tmp_path / "secret.h5", tmp_path / "crafted.h5"
    with h5py.File(secret, "w") as file:
        write_columns(file)
    with h5py.File(path, "w") as file:
        write(file, secret)
    with pytest.raises(FormatError, match=r"^\S+crafted.h5: /\S+ (is a|has its data in an)"):
        read_events(path)


def test_links_within_the_file_are_followed(tmp_path: Path) -> None:
    path = tmp_path / "linked.h5"
    with h5py.File(path, "w") as file:
        write_columns(file.create_group("data"))
        file["events"] = h5py.SoftLink("/data")
        group = file.create_group("again")
        for name in "txyp":
            group[name] = h5py.SoftLink(f"/events/{name}")
        group["parent"] = file["/"]
        file["dangling"] = h5py.SoftLink("/dangling")
    assert read_events(path)["x"].tolist() == [1] * COUNT
