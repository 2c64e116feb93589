"""Geometry without a renderer: the pinhole camera, rigid transforms and image rectangles."""
