"""What the simulator refuses."""


class SimError(ValueError):
    """Base of all errors that the simulator raises on bad input."""


class SceneConfigError(SimError):
    """A scene parameter is outside its range."""


class RendererError(SimError, RuntimeError):
    """This machine cannot render, or the renderer was asked for what it has not."""
