"""The readout: from the events of the pixels to the events that leave the chip."""
