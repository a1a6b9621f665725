"""A part in the making, of one component's config. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeVar

from homebot.devices.part import Category
from homebot.errors import WireError
from homebot.gateways.mqtt.homeassistant.command_topic import CommandTopic
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.said import Said
from homebot.gateways.mqtt.homeassistant.source import Source
from homebot.gateways.mqtt.part_table import PartTable
from homebot.gateways.mqtt.payload import clean_text, shown
from homebot.gateways.mqtt.readings import NOTHING, Readings

__all__ = ["Entity"]

ReadT = TypeVar("ReadT")


class Entity(PartTable[Said]):
    """Collects what one part can do, and what its config says of it.

    Args:
        config: The component's config.
        service_type: See :data:`homebot.devices.device_types.DEVICE_TYPES`.
        tag: What kind it is of its type; by default its ``device_class``.
    """

    def __init__(self, config: Config, service_type: str, tag: str | None = None) -> None:
        super().__init__(
            Said,
            clean_text(config.text("unique_id") or config.discovery_id, _MAX_ID),
            service_type,
            name=config.words("name"),
            advertised=config.component,
            tag=config.words("device_class") if tag is None else tag,
            category=_category(config),
        )

    def hears(self, source: Source | None, read: Callable[[str], Readings]) -> bool:
        """Read the text at *source* with *read*, which never raises; tell whether it can be read.

        Where the template of the source is not supported, the part shows the payload as ``raw`` instead.
        """
        return self._hears(source, _read_text, read)

    def hears_message(self, source: Source | None, read: Callable[[Said, str], Readings]) -> bool:
        """As :meth:`hears`, but *read* is given the whole message before the text."""
        return self._hears(source, _read_source, read)

    def listens_at(self, *commands: CommandTopic | None) -> None:
        """Name the topics that the part listens on."""
        self.listens(*(one.topic for one in commands if one is not None))

    def _hears(self, source: Source | None, opened: Callable[[Source, ReadT, Said], Readings], read: ReadT) -> bool:
        if source is None:
            return False
        if not source.problem:
            self.reads(source.topic, partial(opened, source, read))
            return True
        self.reads(source.topic, partial(_read_raw, source.encoding))
        self.offers("raw")
        return False


_CATEGORIES: Mapping[str, Category] = {"": "", "config": "config", "diagnostic": "diagnostic"}
_MAX_RAW = 255
_MAX_ID = 255


def _category(config: Config) -> Category:
    category = config.text("entity_category")
    if category in _CATEGORIES:
        return _CATEGORIES[category]
    raise WireError(f"{config.component}: entity_category is {shown(category)}, not config or diagnostic")


def _read_source(source: Source, read: Callable[[Said, str], Readings], said: Said) -> Readings:
    text = source.text(said)
    return NOTHING if text is None else read(said, text)


def _read_text(source: Source, read: Callable[[str], Readings], said: Said) -> Readings:
    text = source.text(said)
    return NOTHING if text is None else read(text)


def _read_raw(encoding: str, said: Said) -> Readings:
    text = said.text(encoding)
    return NOTHING if text is None else {"raw": clean_text(text, _MAX_RAW)}
