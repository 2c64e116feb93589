"""Score detectors on windows of real recordings: `flybench validate`."""
