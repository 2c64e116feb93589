"""Commands that make data for others, and measure what filters do to it."""
