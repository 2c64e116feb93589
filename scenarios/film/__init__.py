"""Films of recordings: events over frames, regions, directions, truth and responses."""
