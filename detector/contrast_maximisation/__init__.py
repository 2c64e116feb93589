"""Contrast maximisation: the image velocity for which the image of warped events is sharpest."""
