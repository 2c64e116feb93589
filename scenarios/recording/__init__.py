"""One Rerun recording a sequence: light, events, what each method makes of them, what is true."""

from scenarios.recording.file_recorder import FileRecorder
from scenarios.recording.recorder import Recorder
from scenarios.recording.sequence_recorder import SequenceRecorder

__all__ = ["FileRecorder", "Recorder", "SequenceRecorder"]
