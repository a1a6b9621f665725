"""Loads the class of an app anew, from the files as they are now, while the old one is at work.

The modules keep their names, which recordings hold, and are put back where the new ones turn out not to work. An app
in a file or a module is loaded alone, one in a package with all modules of its folder; homebot's own are never loaded
twice. Python's cache of compiled files is not read: it takes two saves within a second, of one length, for the same.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, Final, final

from homebot import plugins
from homebot.apps import App
from homebot.errors import PluginError

__all__ = ["FreshCode", "source_of"]

_OWN: Final = __name__.partition(".")[0]


@final
class FreshCode:
    """The code of an app, loaded anew.

    Attributes:
        prefix: The module, or the package, that was loaded anew; empty before that, and for homebot's own.
    """

    def __init__(self) -> None:
        self._before: dict[str, ModuleType] = {}
        self.prefix = ""

    def load(self, group: str, name: str) -> type[Any]:
        """Return the class that *name* means, as :func:`homebot.plugins.load_plugin`, or of ``FILE.py``; blocking.

        Raises:
            PluginError: Likewise; the old modules are back then.
        """
        path = plugins.plugin_path(group, name)
        module_name, _, class_name = path.partition(":")
        if plugins.is_file(path):
            return self._load_file(name, *plugins.file_and_class(path))
        if module_name not in sys.modules or module_name.partition(".")[0] == _OWN:
            return plugins.load_plugin(group, name)
        return self._load(name, module_name, class_name, lambda: _import(module_name))

    def _load_file(self, name: str, file: Path, class_name: str | None) -> type[Any]:
        plugins.check_file(file, name)
        module_name = plugins.module_name_of(file.resolve())
        plugins.look_in(file.resolve().parent)
        return self._load(name, module_name, class_name, lambda: _run_file(module_name, file.resolve()))

    def _load(self, name: str, module_name: str, class_name: str | None, run: Callable[[], ModuleType]) -> type[Any]:
        self._take_out(module_name)
        try:
            with _without_cache():
                module = run()
            kind = getattr(module, class_name or plugins.class_in(module, name, App), None)
            if not isinstance(kind, type):
                raise TypeError(f"{class_name} is {kind!r}, not a class")  # noqa: TRY301 - one way back for all
        except (Exception, SystemExit) as exc:
            self.restore()
            raise exc if isinstance(exc, PluginError) else PluginError(name, _problem(exc)) from exc
        return kind

    def restore(self) -> None:
        """Put the old modules back, if any; twice is fine."""
        if self.prefix:
            for name in _modules_of(self.prefix):
                del sys.modules[name]
            sys.modules.update(self._before)
            for name, module in self._before.items():
                parent, _, child = name.rpartition(".")
                if parent in sys.modules:
                    setattr(sys.modules[parent], child, module)
        self._before, self.prefix = {}, ""

    def _take_out(self, module_name: str) -> None:
        module = sys.modules.get(module_name)
        self.prefix = (getattr(module, "__package__", "") or module_name) if module else module_name
        self._before = {name: sys.modules.pop(name) for name in _modules_of(self.prefix)}


def source_of(kind: type[object]) -> Path | None:
    """Return the file of an app, or the folder of its package; None where it is homebot's own, or has none."""
    module = sys.modules.get(kind.__module__)
    file = getattr(module, "__file__", None)
    if module is None or file is None or kind.__module__.partition(".")[0] == _OWN:
        return None
    path = Path(file).resolve()
    return path.parent if module.__package__ else path


def _modules_of(prefix: str) -> tuple[str, ...]:
    return tuple(name for name in sys.modules if name == prefix or name.startswith(f"{prefix}."))


def _problem(error: Exception | SystemExit) -> str:
    return f"cannot be loaded: {plugins.error_text(error)}"


def _import(name: str) -> ModuleType:
    importlib.invalidate_caches()
    return importlib.import_module(name)


def _run_file(name: str, file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None  # noqa: S101 - for the type checker: it has a loader
    assert spec.loader is not None  # noqa: S101 - likewise
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@contextmanager
def _without_cache() -> Iterator[None]:
    before = sys.pycache_prefix, sys.dont_write_bytecode
    sys.pycache_prefix, sys.dont_write_bytecode = os.devnull, True  # a folder below a file: there is nothing in it
    try:
        yield
    finally:
        sys.pycache_prefix, sys.dont_write_bytecode = before
