"""`python -m tests.digests`: SHA-256 digests of what the program computes.

Write the digests before a change that must not affect results, and check them after it.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from fnmatch import fnmatch
from pathlib import Path

from scenarios.options.cache import OFF, VARIABLE
from tests.digests.commands import CASES as COMMANDS
from tests.digests.detectors import CASES as DETECTORS
from tests.digests.exact import Case, digest
from tests.digests.files import CASES as FILES
from tests.digests.luminance import CASES as LUMINANCE
from tests.digests.sensor import CASES as SENSORS

FAILED = "failed"
CASES: dict[str, Case] = LUMINANCE | SENSORS | DETECTORS | FILES | COMMANDS


def compute(only: str, *, fast: bool) -> dict[str, str]:
    """Compute the digests whose names match, and print each with its time."""
    found = {}
    for name, case in CASES.items():
        if fnmatch(name, only) and not (fast and case.slow):
            start_s = time.perf_counter()
            try:
                found[name] = digest(case.compute())
            except Exception as error:  # the other digests are still useful
                found[name] = f"{FAILED}: {type(error).__name__}: {error}"
            spent_s = time.perf_counter() - start_s
            print(f"{found[name]}  {name}  ({spent_s:.1f} s)", flush=True)
    return found


def is_as(file: Path, found: dict[str, str]) -> bool:
    """Compare digests with a file, print the names of those that differ, and return True if all are
    equal."""
    known: dict[str, str] = json.loads(file.read_text(encoding="utf-8"))
    gone = [name for name in known if name not in CASES]
    differing = [name for name in found if found[name] != known.get(name)]
    for name in differing:
        print(f"differs: {name}" if name in known else f"not in {file}: {name}")
    for name in gone:
        print(f"only in {file}: {name}")
    print(f"{len(found) - len(differing)} of {len(found)} digests equal those in {file}")
    return not differing and not gone


def main() -> int:
    """Parse the arguments, compute the digests, and write or check them."""
    parser = argparse.ArgumentParser(prog="python -m tests.digests", description=__doc__)
    parser.add_argument("--write", type=Path, metavar="FILE.json", help="write the digests")
    parser.add_argument("--check", type=Path, metavar="FILE.json", help="compare with a file")
    parser.add_argument("--only", default="*", metavar="GLOB", help="names of digests to compute")
    parser.add_argument("--fast", action="store_true", help="leave out the slow ones")
    arguments = parser.parse_args()
    os.environ[VARIABLE] = OFF
    found = compute(arguments.only, fast=arguments.fast)
    if arguments.write is not None:
        arguments.write.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    failed = any(value.startswith(FAILED) for value in found.values())
    same = arguments.check is None or is_as(arguments.check, found)
    return 0 if same and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
