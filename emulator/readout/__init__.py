"""The readout: the arbiter that takes events off the chip, row by row."""
