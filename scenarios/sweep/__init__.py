"""`flybench sweep`: any grid or random sample of runs, in parallel, resumable, as one table."""
