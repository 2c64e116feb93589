"""What moving objects do to the light on the background: shadows, and the beams of their lamps."""
