"""The event pixel: from luminance to events, for one pixel and for all of them."""
