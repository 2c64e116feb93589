"""The fly of the paper's Section II, one file per stage of the model."""
