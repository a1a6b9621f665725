"""What a configuration asks for: classes found and tables checked, before anything is started."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from pydantic import BaseModel

from homebot.apps import App
from homebot.bridges.rosbridge import DoorSettings
from homebot.config import Config, Table, parse_settings
from homebot.discovery import DirectorySettings
from homebot.errors import ConfigError, PluginError
from homebot.gateways import Gateway
from homebot.plugins import load_plugin

__all__ = ["Component", "Plan", "make_plan"]

GATEWAYS = "homebot.gateways"
APPS = "homebot.apps"

ComponentT = TypeVar("ComponentT", Gateway, App)


@dataclass(frozen=True, slots=True)
class Component(Generic[ComponentT]):
    """A gateway or an app to be started.

    Attributes:
        name: The name of its node.
        kind: Its class.
        settings: Its table, checked by ``kind.Settings``.
    """

    name: str
    kind: type[ComponentT]
    settings: BaseModel


@dataclass(frozen=True, slots=True)
class Plan:
    """A configuration, understood.

    Attributes:
        home: What the home is called.
        gateways: The gateways, in the order of the file.
        apps: The apps, in the order of the file.
        discovery: The directory's settings.
        door: The door's settings.
    """

    home: str
    gateways: tuple[Component[Gateway], ...]
    apps: tuple[Component[App], ...]
    discovery: DirectorySettings
    door: DoorSettings


def make_plan(config: Config) -> Plan:
    """Find every class that *config* names and check every table.

    Raises:
        ConfigError: A class cannot be found, or a table is wrong; names the file, the key and the reason.
    """
    source = config.source
    base_gateway: type[Gateway] = Gateway  # type: ignore[type-abstract]  # only compared with, never made
    base_app: type[App] = App  # type: ignore[type-abstract]  # likewise
    return Plan(
        home=config.home.name,
        gateways=tuple(
            _component(base_gateway, GATEWAYS, name, table, source, f"gateways.{name}")
            for name, table in config.gateways.items()
        ),
        apps=tuple(
            _component(base_app, APPS, name, table, source, f"apps.{name}") for name, table in config.apps.items()
        ),
        discovery=parse_settings(DirectorySettings, config.discovery, source, "discovery"),
        door=parse_settings(DoorSettings, config.door, source, "door"),
    )


def _component(
    base: type[ComponentT], group: str, name: str, table: Table, source: str, key: str
) -> Component[ComponentT]:
    wanted = table.get("class", name)
    if not isinstance(wanted, str):
        raise ConfigError(source, f"{key}.class", f"must be a text, module:Class or a plug-in's name, got {wanted!r}")
    try:
        kind = load_plugin(group, wanted)
    except PluginError as exc:
        raise ConfigError(source, f"{key}.class" if "class" in table else key, str(exc)) from exc
    if not issubclass(kind, base):
        raise ConfigError(source, f"{key}.class", f"{wanted} is no {base.__name__}")
    return Component(name, kind, parse_settings(kind.Settings, table, source, key))
