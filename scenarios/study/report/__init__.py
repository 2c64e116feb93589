"""The report of the study: one HTML page."""
