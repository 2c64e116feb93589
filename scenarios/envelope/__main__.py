"""`python -m scenarios.envelope`."""

from scenarios.envelope.command import Envelope
from scenarios.terminal import script

script(Envelope)
