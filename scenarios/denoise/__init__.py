"""What filters of noise do to events and to detectors, by illuminance."""
