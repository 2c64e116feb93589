"""From events to the direction of motion."""
