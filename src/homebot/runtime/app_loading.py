"""Loads an app from its current files and settings while the old one is running.

The modules keep their names, which are in recordings, and are restored if the new ones do not work. An app in a file or
module is loaded alone, one in a package with all modules of its folder; homebot's own are never loaded twice. Python's
cache of compiled files is not read: it mistakes two saves of equal length within a second for one.
"""

import importlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, Final, final

from homebot import plugins
from homebot.apps import App
from homebot.apps.grants import scope_of
from homebot.config import Config, Table
from homebot.devices.client_rights import CurrentGrants
from homebot.errors import ConfigError, PluginError
from homebot.names import snake_case
from homebot.plugins import file_and_class, is_file
from homebot.runtime.plan import APPS, PlannedComponent, planned_app

_OWN: Final = __name__.partition(".")[0]


@final
class FreshCode:
    """The freshly loaded code of an app.

    Attributes:
        prefix: The module, or the package, that was reloaded; empty before that, and for homebot's own.
    """

    def __init__(self) -> None:
        self._before: dict[str, ModuleType] = {}
        self.prefix = ""

    def load(self, group: str, name: str) -> type[Any]:
        """Return the class *name*, as for :func:`homebot.plugins.load_plugin`, or of ``FILE.py``; blocking.

        Raises:
            PluginError: As for that function; the old modules are restored.
        """
        path = plugins.plugin_path(group, name)
        module_name, _, class_name = path.partition(":")
        if plugins.is_file(path):
            return self._load_file(name, *plugins.file_and_class(path))
        if module_name not in sys.modules or module_name.partition(".")[0] == _OWN:
            return plugins.load_plugin(group, name)
        importlib.invalidate_caches()
        return self._load(name, module_name, class_name, lambda: importlib.import_module(module_name))

    def _load_file(self, name: str, file: Path, class_name: str | None) -> type[Any]:
        plugins.check_file(file, name)
        module_name = plugins.module_name_of(file.resolve())
        plugins.look_in(file.resolve().parent)
        return self._load(name, module_name, class_name, lambda: plugins.run_file(module_name, file.resolve()))

    def _load(self, name: str, module_name: str, class_name: str | None, run: Callable[[], ModuleType]) -> type[Any]:
        loaded = sys.modules.get(module_name)
        self.prefix = (getattr(loaded, "__package__", "") or module_name) if loaded else module_name
        self._before = {name: sys.modules.pop(name) for name in _modules_of(self.prefix)}
        try:
            with _without_cache():
                module = run()
            kind = getattr(module, class_name or plugins.class_in(module, name, App), None)
            if not isinstance(kind, type):
                raise TypeError(f"{class_name} is {kind!r}, not a class")
        except (Exception, SystemExit) as exc:
            self.restore()
            if isinstance(exc, PluginError):
                raise
            raise PluginError(name, f"cannot be loaded: {plugins.error_text(exc)}") from exc
        return kind

    def restore(self) -> None:
        """Restore the old modules, if any; idempotent."""
        if self.prefix:
            for name in _modules_of(self.prefix):
                del sys.modules[name]
            sys.modules.update(self._before)
            for name, module in self._before.items():
                parent, _, child = name.rpartition(".")
                if parent in sys.modules:
                    setattr(sys.modules[parent], child, module)
        self._before, self.prefix = {}, ""


def source_of(kind: type[object]) -> Path | None:
    """Return the file of an app, or the folder of its package; None if it is homebot's own, or has none."""
    module = sys.modules.get(kind.__module__)
    file = getattr(module, "__file__", None)
    if module is None or file is None or kind.__module__.partition(".")[0] == _OWN:
        return None
    path = Path(file).resolve()
    return path.parent if module.__package__ else path


def _modules_of(prefix: str) -> tuple[str, ...]:
    return tuple(name for name in sys.modules if name == prefix or name.startswith(f"{prefix}."))


@contextmanager
def _without_cache() -> Iterator[None]:
    before = sys.pycache_prefix, sys.dont_write_bytecode
    sys.pycache_prefix, sys.dont_write_bytecode = os.devnull, True  # a folder below a file cannot exist
    try:
        yield
    finally:
        sys.pycache_prefix, sys.dont_write_bytecode = before


@final
class AppPlanner:
    """Plans one app at a time. Blocking.

    Args:
        read: Reads the configuration, once for all apps that are planned together.
        add_kept: Returns the configuration with the table of an app that a feature keeps.
        given: The classes of apps that keep theirs.
    """

    def __init__(
        self,
        read: Callable[[], Config],
        add_kept: Callable[[Config, str], Config],
        grants: CurrentGrants,
        given: Mapping[str, type[App]],
    ) -> None:
        self.read = read
        self._add_kept = add_kept
        self._grants = grants
        self._given = given
        self._files: dict[str, str] = {}

    def plan(self, name: str, config: Config, *, is_new: bool) -> tuple[PlannedComponent[App], FreshCode]:
        """Return the app *name* of *config* and its code, which can be restored.

        Raises:
            ConfigError: It cannot be loaded, or its table is wrong; the old code is restored.
            PluginError: Its file cannot be loaded; the old code is restored.
        """
        config, code = self._add_kept(config, name), FreshCode()
        try:
            if is_new and is_file(name):
                kind = code.load(APPS, name)
                app = snake_case(kind.__name__)
                path = f"{file_and_class(name)[0]}:{kind.__name__}"
                planned = self._check(app, {**config.apps.get(app, {}), "class": path}, config, lambda *_: kind)
                self._files[app] = path
                return planned, code
            table = dict(config.apps.get(name, {}))
            if name not in config.apps and name in self._files:
                table["class"] = self._files[name]
            return self._check(name, table, config, code.load), code
        except BaseException as exc:
            code.restore()
            if isinstance(exc, ConfigError):
                from homebot.config_lines import located  # noqa: PLC0415 - after a mistake alone

                raise located(exc) from exc
            raise

    def _check(
        self, name: str, table: Table, config: Config, load: Callable[[str, str], type[App]]
    ) -> PlannedComponent[App]:
        planned = planned_app(name, table, config, self._given.get(name), load)
        if scope_of(f"apps.{name}", table, config.source) != self._grants.now.scopes.get(f"/{name}"):
            raise ConfigError(
                config.source,
                f"apps.{name}.act",
                "has changed; reload the configuration first: kill -HUP, or systemctl [--user] reload homebot",
            )
        return planned
