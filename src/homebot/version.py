"""The version of homebot."""

__all__ = ["__version__"]

__version__ = "0.1.0"
