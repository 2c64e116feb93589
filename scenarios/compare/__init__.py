"""Comparison of two recordings by their statistics."""
