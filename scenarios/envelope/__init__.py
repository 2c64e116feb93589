"""The operating envelope of a detector: where it is right, measured on drawn stimuli."""
