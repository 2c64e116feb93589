"""A folder of rendered luminance, so that a sequence is rendered once."""
