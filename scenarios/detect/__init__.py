"""A direction from anybody's events: `flybench detect`."""
