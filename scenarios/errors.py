"""What the commands refuse."""


class ScenarioError(ValueError):
    """Base of all errors that the commands raise on bad input."""


class OutputError(ScenarioError):
    """Something cannot be written where it was asked to be."""
