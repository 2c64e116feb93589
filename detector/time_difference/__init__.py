"""Time difference encoders (Milde et al., 2018; D'Angelo et al., 2020)."""
