"""`python -m scenarios.sweep`."""

from scenarios.sweep.command import Sweep
from scenarios.terminal import script

script(Sweep)
