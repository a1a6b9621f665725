"""The application layer."""

from homebot.apps.base import App, NoSettings

__all__ = ["App", "NoSettings"]
