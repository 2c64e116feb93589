"""The events of a run: an HDF5 file in the layout of the DSEC data set."""

from formats import read_events
from formats.writers.dsec import DsecWriter

__all__ = ["DsecWriter", "read_events"]
