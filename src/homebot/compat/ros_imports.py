"""``import rclpy`` and ``from std_msgs.msg import String`` in programs that were written for ROS."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Final

from homebot.compat.interfaces import message_class, to_action, to_service
from homebot.errors import UsageError
from homebot.messages.interfaces import Interfaces, find_action, find_message, find_service, interface_names

__all__ = ["install_ros_imports"]

_MODULES: Final = ("", ".action", ".executors", ".logging", ".node", ".parameter", ".qos", ".task")
_KINDS: Final = ("msg", "srv", "action")


def install_ros_imports(folders: Sequence[Path] = ()) -> None:
    """Make ``rclpy`` and the packages of interfaces importable, before those of a ROS that is installed. Idempotent.

    Args:
        folders: Folders of further interfaces, ``PACKAGE/msg/NAME.msg`` and so on.

    Raises:
        OSError: A folder cannot be read.
        UsageError: A file in it is no interface.
    """
    for name in _MODULES:
        sys.modules[f"rclpy{name}"] = import_module(f"homebot.compat.rclpy{name}")
    sys.meta_path[:] = [one for one in sys.meta_path if not isinstance(one, _InterfaceFinder)]
    texts = {key: text for folder in folders for key, text in Interfaces.read_folder(folder).items()}
    sys.meta_path.insert(0, _InterfaceFinder(Interfaces(texts), frozenset(texts)))


class _InterfaceFinder(MetaPathFinder, Loader):
    """Finds ``PACKAGE`` and ``PACKAGE.msg``, ``.srv`` and ``.action`` where there are interfaces of the package."""

    def __init__(self, further: Interfaces, keys: frozenset[str]) -> None:
        self._further = further
        self._keys = keys
        self._packages = {key.partition("/")[0] for key in keys}

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        package, _, kind = fullname.partition(".")
        if kind and kind not in _KINDS:
            return None
        if package not in self._packages and not interface_names(package):
            return None
        return ModuleSpec(fullname, self, is_package=not kind)

    def exec_module(self, module: ModuleType) -> None:
        """Make the interfaces of a package names of *module*, each loaded when it is first asked for."""
        package, _, kind = module.__name__.partition(".")

        def interface(name: str) -> object:
            if name.startswith("_") or not kind:
                raise AttributeError(name)
            try:
                return self._interface(f"{package}/{kind}/{name}", kind)
            except UsageError as exc:
                raise ImportError(str(exc)) from exc

        setattr(module, "__getattr__", interface)  # noqa: B010 - the hook of a module, PEP 562

    def _interface(self, key: str, kind: str) -> object:
        is_further = key in self._keys
        if kind == "msg":
            return message_class(self._further.find_message(key) if is_further else find_message(key))
        if kind == "srv":
            return to_service(self._further.find_service(key) if is_further else find_service(key))
        return to_action(self._further.find_action(key) if is_further else find_action(key))
