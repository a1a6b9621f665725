"""The application layer."""

from homebot.apps.base import App, AppContext, AppSettings, NoSettings

__all__ = ["App", "AppContext", "AppSettings", "NoSettings"]
