"""Emulate a sensor that looks at a video, images or an array: `flybench emulate`."""
