"""The labels of a sequence: one module for each kind of file."""
