"""Conversion of recordings from one format to another."""
