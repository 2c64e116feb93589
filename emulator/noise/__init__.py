"""Noise of the event pixels: random numbers, photoreceptor noise, leak and faulty pixels."""
