"""The version of homebot."""

__version__ = "0.2.0"
