"""Luminance at every sample from a few rendered keyframes and exact geometry."""
