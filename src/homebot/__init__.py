"""homebot: the home runtime for robots."""

__version__ = "0.1.0"
