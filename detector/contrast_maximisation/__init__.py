"""Contrast maximisation: the image velocity that makes the warped events sharpest."""
