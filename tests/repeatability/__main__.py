"""`python -m tests.repeatability`: draw scenarios in many fresh processes and compare the light.

The default draws 30 scenarios in 50 processes each, which takes hours.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch

from tests.repeatability.drawing import drawing_digest, scenarios

PROCESSES = 50


def fresh_digest(name: str) -> str:
    """Return a scenario's digest from a process of its own.

    Raises:
        RuntimeError: the process failed.
    """
    command = [sys.executable, "-m", "tests.repeatability", "--one", name]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{name} could not be drawn: {done.stderr.strip()[-500:]}")
    return done.stdout.split()[-1]


def main() -> int:
    """Draw each scenario in fresh processes and print the number of draws that differ."""
    parser = argparse.ArgumentParser(prog="python -m tests.repeatability", description=__doc__)
    parser.add_argument("--only", default="*", metavar="GLOB", help="names of scenarios to draw")
    parser.add_argument("--processes", type=int, default=PROCESSES, help="processes a scenario")
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time")
    parser.add_argument("--one", metavar="NAME", help="print the digest of one scenario")
    arguments = parser.parse_args()
    if arguments.one is not None:
        print(drawing_digest(scenarios()[arguments.one]))
        return 0
    names = [name for name in scenarios() if fnmatch(name, arguments.only)]
    differing = draws = 0
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for name in names:
            found = Counter(pool.map(fresh_digest, [name] * arguments.processes))
            most = found.most_common(1)[0][1]
            differing += found.total() - most
            draws += found.total()
            print(f"{name}: {found.total() - most} of {found.total()} draws differ", flush=True)
    print(f"{differing} of {draws} draws of {len(names)} scenarios differ")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
