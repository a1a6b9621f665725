"""The topic layout of the thesis."""

from homebot.conventions.thesis.convention import Thesis, ThesisSettings

__all__ = ["Thesis", "ThesisSettings"]
