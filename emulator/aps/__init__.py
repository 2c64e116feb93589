"""The active pixel sensor: frames exposed over the same light as the events."""
