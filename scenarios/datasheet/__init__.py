"""Presentation of a sensor's data sheet: as an HTML page and as JSON."""
