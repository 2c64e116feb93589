"""Disk cache of rendered luminance."""
