"""Plans apps that are loaded or reloaded while homebot runs, by files and settings as they are then."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import final

from homebot.apps import App
from homebot.config import Config, Table
from homebot.errors import ConfigError
from homebot.names import snake_case
from homebot.plugins import file_and_class, is_file
from homebot.runtime.app_loading import FreshCode
from homebot.runtime.grants import scope_of
from homebot.runtime.plan import APPS, PlannedComponent, planned_app

__all__ = ["AppPlanner"]


@final
class AppPlanner:
    """Plans one app at a time. Blocking.

    Args:
        grants: The scopes of apps by their nodes, replaced when the configuration is reloaded.
    """

    def __init__(self, read_config: Callable[[], Config], grants: Mapping[str, tuple[str, ...]]) -> None:
        self._read_config = read_config
        self._grants = grants
        self._files: dict[str, str] = {}

    def plan(self, name: str, *, is_new: bool) -> tuple[PlannedComponent[App], FreshCode]:
        """Return the app *name* and its code, which can be taken back.

        Raises:
            ConfigError: It cannot be loaded, or its table is wrong; its old code is back then.
            PluginError: Its file cannot be loaded; likewise.
        """
        config, code = self._read_config(), FreshCode()
        try:
            if is_new and is_file(name):
                return self._plan_file(config, name, code), code
            table = dict(config.apps.get(name, {}))
            if name not in config.apps and name in self._files:
                table["class"] = self._files[name]
            return self._checked(name, table, config, code.load), code
        except BaseException:
            code.restore()
            raise

    def _plan_file(self, config: Config, name: str, code: FreshCode) -> PlannedComponent[App]:
        kind = code.load(APPS, name)
        app = snake_case(kind.__name__)
        path = f"{file_and_class(name)[0]}:{kind.__name__}"
        planned = self._checked(app, {**config.apps.get(app, {}), "class": path}, config, lambda *_: kind)
        self._files[app] = path
        return planned

    def _checked(
        self, name: str, table: Table, config: Config, load: Callable[[str, str], type[App]]
    ) -> PlannedComponent[App]:
        planned = planned_app(name, table, config, load)
        if scope_of(f"apps.{name}", table, config) != self._grants.get(f"/{name}"):
            raise ConfigError(
                config.source,
                f"apps.{name}.act",
                "has changed; reload the configuration first: kill -HUP, or systemctl reload homebot",
            )
        return planned
