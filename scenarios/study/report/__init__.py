"""The study's report: one HTML page."""
