"""Objects of an HDF5 file that lie in the file itself.

An HDF5 file can refer to other files: by external links, by data sets whose data are in other
files, and by virtual data sets, which consist of parts of others. The HDF5 library follows them
all, so that somebody else's file could make us read any file of this machine. They are refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import h5py

from formats.errors import FormatError

_STEPS_MAX = 100
"""Most names on the way to an object, those of soft links among them (assumed)."""


def children(group: Any) -> Iterator[tuple[str, Any]]:
    """Yield name and object of each link of a group that leads to an object of this file.

    Raises:
        FormatError: a link or a data set refers to another file.
    """
    for name in group:
        item = find(group, name)
        if item is not None:
            yield name, item


def find(group: Any, path: str) -> Any:
    """Return the object at a path, or None if there is none.

    Args:
        group: group at which the path starts.
        path: names of links, separated by slashes; soft links are followed within the file.

    Raises:
        FormatError: the path or the object refers to another file.
    """
    here, names = group, path.split("/")[::-1]
    for _ in range(_STEPS_MAX):
        if not names:
            check_storage(here)
            return here
        name = names.pop()
        if name in ("", "."):
            continue
        if not isinstance(here, h5py.Group) or name not in here.id:
            return None
        link = here.id.links.get_info(name.encode("utf-8", "surrogateescape"))
        if link.type == h5py.h5l.TYPE_HARD:
            here = here[name]
        elif link.type == h5py.h5l.TYPE_SOFT:
            target = here.get(name, getlink=True).path
            here = here["/"] if target.startswith("/") else here
            names += target.split("/")[::-1]
        else:
            raise _elsewhere(here, f"{here.name.rstrip('/')}/{name}", "is a link to another file")
    return None


def check_storage(item: Any) -> None:
    """Refuse a data set whose data are in other files, or could be; not even its shape is read.

    Raises:
        FormatError: the data set has external storage or is virtual.
    """
    if not isinstance(item, h5py.Dataset):
        return
    plist = item.id.get_create_plist()
    if plist.get_external_count():
        raise _elsewhere(item, item.name, "has its data in another file")
    if plist.get_layout() == h5py.h5d.VIRTUAL:
        raise _elsewhere(item, item.name, "is a virtual data set, which consists of others")


def _elsewhere(item: Any, name: str, problem: str) -> FormatError:
    return FormatError(
        f"{item.file.filename}: {name} {problem}. Allowed are files that contain all their data, "
        "because others could make flybench read any file. Copy the data into one file."
    )
