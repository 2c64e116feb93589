"""Commands that measure a sensor."""
