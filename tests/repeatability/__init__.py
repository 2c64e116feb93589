"""Proof that the same scenario gives the same luminance in every process."""
