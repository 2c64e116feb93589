"""The event-driven fly of the paper (Section II), one file per stage of the model."""
