"""From luminance to a scored decision: detectors, runs, scores and summaries."""
