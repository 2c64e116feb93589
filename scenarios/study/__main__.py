"""`python -m scenarios.study`."""

from scenarios.study.command import Study
from scenarios.terminal import script

script(Study)
