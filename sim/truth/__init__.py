"""Ground truth at any time: every moving object, and depth and optical flow of every pixel."""
