"""Exact visibility without a renderer: triangles scan-converted on the pixel or sub-pixel grid."""
