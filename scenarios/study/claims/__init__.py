"""The claims of the paper, each held against the study's results."""
