"""Sweeps: a grid or random sample of runs, in parallel and resumable, with one results table."""
