"""The application layer."""

from homebot.apps.base import App, AppSettings, NoSettings
from homebot.apps.context import AppContext

__all__ = ["App", "AppContext", "AppSettings", "NoSettings"]
