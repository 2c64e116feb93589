"""Calibration: the parameters of a sensor, estimated from a recording with frames."""
