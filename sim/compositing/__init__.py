"""One sample, put together from the background, its shadows and beams, and moving parts."""
