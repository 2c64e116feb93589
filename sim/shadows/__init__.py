"""Effects of moving objects on the background: their shadows, and the beams of their lamps."""
