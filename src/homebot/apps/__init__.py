"""Apps: base class, built-in apps, and the services of the home that they use; features add names."""

from homebot.apps.base import App, AppSettings, NoSettings
from homebot.apps.context import AppContext
from homebot.feature import all_features, load

__all__ = ["App", "AppContext", "AppSettings", "NoSettings"]


def __getattr__(name: str) -> object:
    for feature in all_features():
        if name in feature.app_names:
            return load(feature.app_names[name])
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
