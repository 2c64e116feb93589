"""Everything between luminance and a scored decision: detectors, runs, scores and summaries."""
