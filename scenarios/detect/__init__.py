"""Run a detector on a recording of any event camera: `flybench detect`."""
