"""Rerun recordings: preview, events, frames, ground truth, and the estimates of each method."""

from scenarios.recording.file_recorder import FileRecorder
from scenarios.recording.recorder import Recorder
from scenarios.recording.sequence_recorder import SequenceRecorder

__all__ = ["FileRecorder", "Recorder", "SequenceRecorder"]
