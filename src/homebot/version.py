"""The version of homebot."""

__version__ = "0.1.0"
