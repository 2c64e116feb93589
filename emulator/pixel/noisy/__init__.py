"""The event pixel with noise: noise on the signal, which crosses the thresholds of each pixel."""
