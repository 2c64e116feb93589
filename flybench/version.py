"""The version of flybench, from its installed metadata."""

from importlib.metadata import version

__version__ = version("flybench")
