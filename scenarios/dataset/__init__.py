"""Labelled datasets: random scenes with every truth, in the layout of DSEC."""
