"""The active pixel sensor (APS): frames exposed to the same luminance as the event pixels."""
