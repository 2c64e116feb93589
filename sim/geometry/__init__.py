"""Geometry without a renderer: cameras, rigid transforms, triangles and image rectangles."""
