"""Ground truth: every moving object, and dense depth and flow, at any time."""
