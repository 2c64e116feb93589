"""Single runs: one sequence written to a folder, and the table of one or more runs."""
