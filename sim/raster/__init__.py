"""Exact visibility: triangles scan-converted at the pixel grid, without a renderer."""
