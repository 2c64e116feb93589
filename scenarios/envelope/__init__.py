"""The operating envelope of a detector: where it is correct, measured on synthetic stimuli."""
