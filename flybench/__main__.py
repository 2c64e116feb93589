"""The command: `flybench`, or `python -m flybench`."""

import atexit
import importlib.util
import os
import shutil
import signal
import sys
import tempfile
from pathlib import Path

from flybench.sources import PACKAGES
from flybench.version import __version__

_FOLDERS: list[str] = []
"""Temporary folders to remove at the end."""


def main() -> None:
    """Run the command, or print the name of the library that is missing."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, _end)  # until the command runs: the libraries load slowly
    if sys.argv[1:] == ["--version"]:
        print(f"flybench {__version__}")
        return
    _give_matplotlib_a_folder()
    _refuse_other_packages()
    try:
        from scenarios.cli import main as run

        run()
    except ModuleNotFoundError as error:
        library = str(error.name).partition(".")[0]
        sys.exit(
            f"flybench: the command needs the library {library}, which is not installed. "
            "Install all that it needs with: pip install 'flybench[all]'"
        )


def _refuse_other_packages() -> None:
    """End with one sentence if another module has the name of one of our packages."""
    root = Path(__file__).resolve().parent.parent
    for name in PACKAGES:
        spec = importlib.util.find_spec(name)
        origin = None if spec is None else spec.origin
        if origin is not None and Path(origin).resolve().parent != root / name:
            sys.exit(
                f"flybench: {origin} hides the package {name} of flybench, which is in "
                f"{root / name}. Rename that file, or start flybench in another folder or with "
                "another PYTHONPATH."
            )


def _give_matplotlib_a_folder() -> None:
    """Give Matplotlib a temporary folder if the home folder cannot be written to.

    Matplotlib would otherwise print two lines of advice before every command.
    """
    if "MPLCONFIGDIR" in os.environ:
        return
    try:
        tempfile.TemporaryFile(dir=Path.home()).close()
    except OSError:
        os.environ["MPLCONFIGDIR"] = folder = tempfile.mkdtemp(prefix="flybench-")
        _FOLDERS.append(folder)
        atexit.register(_remove_folders)


def _remove_folders() -> None:
    for folder in _FOLDERS:
        shutil.rmtree(folder, ignore_errors=True)


def _end(*_: object) -> None:
    """End at once on Ctrl-C: an exception while a library loads could be caught or replaced."""
    os.write(2, b"flybench: interrupted\n")
    _remove_folders()
    os._exit(130)


if __name__ == "__main__":
    main()
