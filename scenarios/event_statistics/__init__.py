"""Statistics of a recording of events that matter for motion detectors, in constant memory."""
