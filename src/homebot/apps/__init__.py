"""The application layer."""

from homebot.apps.base import App, AppSettings, NoSettings

__all__ = ["App", "AppSettings", "NoSettings"]
