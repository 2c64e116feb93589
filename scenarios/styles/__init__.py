"""Styles of figures, tables and recordings: how methods and lightings look."""
