"""The interfaces known to homebot: the built-in ones, those of the owner's folders, and those of its clients."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache, lru_cache
from importlib import import_module
from pathlib import Path
from pkgutil import get_data
from threading import RLock
from typing import Any, Final

from homebot.errors import UnknownTypeError, UsageError
from homebot.messages.action import ActionType
from homebot.messages.definition import fields_of
from homebot.messages.interfaces.interface_text import (
    KINDS,
    Interface,
    ParsedMessage,
    build_interface,
    interface_key,
    messages_in,
    parse_interface,
    split_definitions,
)
from homebot.messages.message import Message, ServiceType
from homebot.support.names import similar_to

_DEFAULT: Final = "jazzy"
_HOME: Final = "homebot.messages"
_PACKAGES: Final = (
    "action_msgs builtin_interfaces geometry_msgs rcl_interfaces std_msgs std_srvs tf2_msgs unique_identifier_msgs"
)
_CLASSES: Final = {package: f"{_HOME}.{package}" for package in _PACKAGES.split()} | {
    "diagnostic_msgs": f"{_HOME}.key_value"
}
"""The modules with classes of packages that homebot itself uses, which take precedence over text definitions."""

_MAX_DEFINED: Final = 200
"""The limit of types of one client."""

_MAX_TEXT: Final = 65_536
_MAX_FIELDS: Final = 300
_DEEPEST: Final = 20
_MAX_VALUES: Final = 100_000
"""The limit of values in a message, not counting variable-length arrays: nested fixed arrays could be huge."""

_MAX_NAME: Final = 100


class Interfaces:
    """The interfaces known by name; each class is built once, on first use, in any thread.

    Args:
        texts: The owner's definitions by ``package/kind/Name``; see :meth:`read_folder`.
        distribution: The ROS 2 distribution whose definitions are used: ``humble``, ``jazzy`` or ``kilted``.
    """

    def __init__(self, texts: Mapping[str, str] | None = None, distribution: str = _DEFAULT) -> None:
        self._texts = dict(texts or {})
        self.distribution = distribution
        self._modules: dict[str, tuple[str, ...]] = {package: (module,) for package, module in _CLASSES.items()}
        self._defined: Counter[str] = Counter()
        self._built: dict[str, Interface] = {}
        self._open: list[str] = []
        self._lock = RLock()

    @staticmethod
    def read_folder(folder: Path) -> dict[str, str]:
        """Return the text of every interface file below *folder* by key; its package is the folder above its kind.

        Raises:
            OSError: A file or folder cannot be read.
            UsageError: There is no such folder, or a file has an invalid name or is not text.
        """
        if not folder.is_dir():
            raise UsageError(f"there is no folder {folder}")
        texts = {}
        for path in sorted(path for kind in KINDS for path in folder.rglob(f"{kind}/*.{kind}")):
            kind = path.parent.name
            key = interface_key(f"{path.parent.parent.resolve().name}/{kind}/{path.stem}", kind)
            if not key:
                raise UsageError(f"{path}: an interface is PACKAGE/{kind}/Name.{kind}, its name in CamelCase")
            try:
                texts[key] = path.read_text(encoding="utf-8-sig")
            except UnicodeDecodeError as exc:
                raise UsageError(f"{path} is not UTF-8 text: {exc}") from exc
        return texts

    def add_modules(self, package: str, modules: tuple[str, ...]) -> None:
        """Add the classes of *package* that *modules* export; these are loaded on first use."""
        self._modules[package] = modules

    def find_message(self, ros_type: str) -> type[Message]:
        """Return the message called *ros_type*, ``package/msg/Name`` or ``package/Name``.

        Raises:
            UnknownTypeError: There is no such message; the error suggests similar names.
            UsageError: Its definition is invalid.
        """
        message_type: type[Message] = self._find(ros_type, "msg")
        return message_type

    def find_service(self, ros_type: str) -> ServiceType[Any, Any]:
        """Return the service called *ros_type*, as :meth:`find_message` does."""
        service_type: ServiceType[Any, Any] = self._find(ros_type, "srv")
        return service_type

    def find_action(self, ros_type: str) -> ActionType[Any, Any, Any]:
        """Return the action called *ros_type*, as :meth:`find_message` does."""
        action_type: ActionType[Any, Any, Any] = self._find(ros_type, "action")
        return action_type

    def names(self, package: str = "") -> tuple[str, ...]:
        """Return the known interfaces as ``package/kind/Name``, sorted; only those of *package* if it is given."""
        known = {*_shipped_names(), *self._texts}
        for own in self._modules.keys() - _CLASSES:
            known |= self._classes_of(own).keys()
        return tuple(sorted(key for key in known if not package or key.startswith(f"{package}/")))

    def define(self, ros_type: str, definition: str, client: str = "") -> Interface:
        """Define *ros_type* (``package/kind/Name``) for *client* with the text of its file and of nested messages.

        Nested messages follow in the form of ``gendeps --cat`` and recordings: a line of 80 ``=``, a line ``MSG:
        package/Name``. A known type must have the same fields.

        Raises:
            UsageError: The definition is invalid, too large, or differs from the known one; the client has too many
            types, or the package belongs to homebot.
        """
        key, texts = _split(ros_type[:_MAX_NAME], definition)
        parsed = {name: parse_interface(name, text) for name, text in texts.items()}
        if sum(len(message.fields) for messages in parsed.values() for message in messages) > _MAX_FIELDS:
            raise UsageError(f"{key}: the definition has more than {_MAX_FIELDS} fields")
        new = {}
        for name, messages in parsed.items():
            if self._is_known(name):
                self._check_same(name, messages)
            elif (package := name.partition("/")[0]) in self._modules:
                hint = "choose another, or let the owner add a folder to `interfaces` of [ros]"
                raise UsageError(f"{name}: the package {package} is not for types of clients; {hint}")
            else:
                new[name] = texts[name]
        if new and self._defined[client] + len(new) > _MAX_DEFINED:
            raise UsageError(f"{key}: this client has defined {self._defined[client]} types, of {_MAX_DEFINED} at most")
        self._add(new, parsed)
        self._defined[client] += len(new)
        return self._resolve(key)

    def _add(self, texts: Mapping[str, str], names: Iterable[str]) -> None:
        """Build the types *names* from the definitions *texts*; after an error they remain unknown."""
        before = dict(self._built), dict(self._texts)
        self._texts |= texts
        try:
            for name in names:
                _check_size(name, messages_in(self._resolve(name)))
        except UsageError:
            self._built, self._texts = before
            raise

    def _find(self, ros_type: str, kind: str) -> Any:
        shown = ros_type[:_MAX_NAME]
        key = interface_key(shown, kind)
        if not key or not self._is_known(key):
            raise UnknownTypeError(shown, _KIND_NAMES[kind], self._similar(key or shown, kind))
        return self._resolve(key)

    def _is_known(self, key: str) -> bool:
        return any(key in known for known in (self._built, self._texts, _shipped_names(), self._classes_of(key)))

    def _similar(self, key: str, kind: str) -> list[str]:
        """Return similar names to the unknown *key*, from packages with similar names."""
        package, slash, name = key.rpartition(f"/{kind}/")
        known = [known for known in self.names() if f"/{kind}/" in known]
        packages = {known.partition("/")[0] for known in known}
        if kind == "msg" and slash:  # only messages: services and actions of tutorials have similar names everywhere
            packages = {*similar_to(package, packages, 0.7)}
        names = {known.rpartition("/")[2]: known for known in known if known.partition("/")[0] in packages}
        return [names[similar] for similar in similar_to(name, names, 0.7)]

    def _resolve(self, key: str) -> Interface:
        with self._lock:
            if key not in self._built:
                self._built[key] = self._classes_of(key).get(key) or self._build(key)
            return self._built[key]

    def _build(self, key: str) -> Interface:
        if key not in self._texts:
            return _shipped_interface(key, self.distribution)
        if key in self._open:
            raise UsageError(f"{key} contains itself, through {', '.join(self._open)}")
        self._open.append(key)
        try:
            return build_interface(key, parse_interface(key, self._texts[key]), self.find_message)
        except UnknownTypeError as exc:
            raise UsageError(f"{key} has a field of an {exc}") from exc
        finally:
            self._open.pop()

    def _classes_of(self, key: str) -> Mapping[str, Interface]:
        return _classes_in(self._modules.get(key.partition("/")[0], ()))

    def _check_same(self, key: str, parsed: Iterable[ParsedMessage]) -> None:
        known = [[field.declaration for field in fields_of(message)] for message in messages_in(self._resolve(key))]
        given = [[field.declaration for field in message.fields.values()] for message in parsed]
        if known != given:
            fields = " --- ".join(", ".join(names) for names in known)
            raise UsageError(f"{key} is known with other fields ({fields}); give the type another name")


_KIND_NAMES: Final = {"msg": "message", "srv": "service", "action": "action"}


def _split(ros_type: str, definition: str) -> tuple[str, dict[str, str]]:
    """Return the key of *ros_type*, and the texts of it and of the messages after it, by key."""
    kind = next((kind for kind in KINDS if f"/{kind}/" in ros_type), "msg")
    key = interface_key(ros_type, kind)
    if not key:
        raise UsageError(f"{ros_type!r} is not a type; write package/msg/Name, or with srv or action")
    if len(definition) > _MAX_TEXT:
        raise UsageError(f"{key}: the definition has {len(definition)} characters, at most {_MAX_TEXT} are read")
    return key, split_definitions(key, definition)


def _check_size(key: str, messages: Iterable[type[Message]]) -> None:
    for values, depth in map(_size, messages):
        if values > _MAX_VALUES or depth > _DEEPEST:
            raise UsageError(
                f"{key} holds {values} values in {depth} levels, at most {_MAX_VALUES} in {_DEEPEST} are possible"
            )


@lru_cache(maxsize=1024)
def _size(message: type[Message]) -> tuple[int, int]:
    """Return the number of values in a message, without variable-length arrays, and of its levels."""
    values, depth = 1, 1
    for field in fields_of(message):
        inner, levels = _size(field.message) if field.message is not None else (1, 0)
        values += inner * (field.size or 1)
        depth = max(depth, levels + 1)
    return values, depth


@lru_cache
def _classes_in(modules: tuple[str, ...]) -> Mapping[str, Interface]:
    """Return the interfaces that *modules* export by a list, or else have, by name; no messages of services."""
    names = [vars(import_module(module)) for module in modules]
    exported = (defined[name] for defined in names for name in defined.get("__all__", defined))
    known = (interface for interface in exported if hasattr(interface, "ros_type"))
    return {
        interface.ros_type: interface
        for interface in known
        if interface_key(interface.ros_type, interface.ros_type.split("/")[1])
    }


@lru_cache
def _shipped_names() -> frozenset[str]:
    return frozenset(_read("names").split())


@cache
def _shipped_interface(key: str, distribution: str) -> Interface:
    """Return the class of a shipped definition, shared by all its users."""
    text, owner = _shipped_text(key, distribution)
    if owner != distribution:
        return _shipped_interface(key, owner)
    return build_interface(key, parse_interface(key, text), find_message)


def _shipped_text(key: str, distribution: str) -> tuple[str, str]:
    """Return the shipped definition of *key* in *distribution*, and the distribution that it comes from."""
    path = f"{key}.{key.split('/')[1]}"
    with suppress(FileNotFoundError):
        return _read(f"distributions/{distribution}/{path}"), distribution
    return _read(path), _DEFAULT


def _read(path: str) -> str:
    """Return the text of the shipped file *path*, through the loader of the package."""
    return (get_data(_HOME, f"share/{path}") or b"").decode()


_SHIPPED: Final = Interfaces()

find_message = _SHIPPED.find_message
find_service = _SHIPPED.find_service
find_action = _SHIPPED.find_action
interface_names = _SHIPPED.names
