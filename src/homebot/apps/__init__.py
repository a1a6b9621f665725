"""Apps: base class, built-in apps, and the services of the home that they use."""

from homebot.apps.base import App, AppSettings, NoSettings
from homebot.apps.context import AppContext

__all__ = ["App", "AppContext", "AppSettings", "NoSettings"]
