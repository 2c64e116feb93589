"""One Rerun recording a run: light, events, what the fly makes of them, and what is true."""

from scenarios.recording.recorder import Recorder

__all__ = ["Recorder"]
