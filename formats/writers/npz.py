"""NumPy archive of the arrays t, x, y, p, width and height."""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from contextlib import suppress
from pathlib import Path
from typing import IO

import numpy as np

from flybench.events import EVENT_DTYPE, Events
from formats.writers.base import EventWriter


class NpzWriter(EventWriter):
    """Writes each column to an unnamed temporary file and joins them in one archive at the end.

    The header of an array states its length, which is only known at the end.
    """

    def _open(self, work: Path) -> None:
        self._spools: dict[str, IO[bytes]] = {}
        work.touch()
        for name in EVENT_DTYPE.names or ():
            self._spools[name] = tempfile.TemporaryFile(dir=work.parent)  # noqa: SIM115
        self._count = 0

    def _write(self, events: Events) -> None:
        for name, spool in self._spools.items():
            spool.write(np.ascontiguousarray(events[name]).data)
        self._count += events.size

    def _finish(self) -> None:
        with zipfile.ZipFile(self._work, "w", zipfile.ZIP_STORED) as archive:
            for name, spool in self._spools.items():
                dtype = EVENT_DTYPE.fields[name][0]  # type: ignore[index]
                spool.seek(0)
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    _header(member, dtype, (self._count,))
                    shutil.copyfileobj(spool, member, 1 << 20)
            for name, side in (("width", self.width), ("height", self.height)):
                with archive.open(f"{name}.npy", "w") as member:
                    _header(member, np.dtype("<i8"), ())
                    member.write(np.int64(side).tobytes())
        self._abandon()

    def _abandon(self) -> None:
        for spool in self._spools.values():
            with suppress(OSError):
                spool.close()


def _header(file: IO[bytes], dtype: np.dtype[np.generic], shape: tuple[int, ...]) -> None:
    description = np.lib.format.dtype_to_descr(dtype)
    np.lib.format.write_array_header_1_0(
        file, {"descr": description, "fortran_order": False, "shape": shape}
    )
