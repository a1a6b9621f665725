"""A part in the making, of one component's config. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeVar

from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.homeassistant.command_topic import CommandTopic
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.incoming import StateMessage
from homebot.conventions.homeassistant.value_source import ValueSource
from homebot.conventions.part_builder import PartBuilder
from homebot.conventions.payload import clean_text, shown
from homebot.devices.part import Category
from homebot.errors import WireError

__all__ = ["Entity"]

ReadT = TypeVar("ReadT")


class Entity(PartBuilder[StateMessage]):
    """Collects what one part can do, and what its config says of it.

    Args:
        config: The component's config.
        service_type: See :data:`homebot.devices.device_types.DEVICE_TYPES`.
        tag: What kind it is of its type; by default its ``device_class``.
    """

    def __init__(self, config: DiscoveryConfig, service_type: str, tag: str | None = None) -> None:
        super().__init__(
            StateMessage,
            clean_text(config.text("unique_id") or config.discovery_id, _MAX_ID),
            service_type,
            name=config.clean_text("name"),
            advertised=config.component,
            tag=config.clean_text("device_class") if tag is None else tag,
            category=_category(config),
        )

    def read_text_from(self, source: ValueSource | None, read: Callable[[str], Readings]) -> bool:
        """Read the text at *source* with *read*, which never raises; tell whether it can be read.

        Where the template of the source is not supported, the part shows the payload as ``raw`` instead.
        """
        return self._add_reader(source, _read_text, read)

    def read_message_from(self, source: ValueSource | None, read: Callable[[StateMessage, str], Readings]) -> bool:
        """As :meth:`read_text_from`, but *read* is given the whole message before the text."""
        return self._add_reader(source, _read_source, read)

    def add_commands(self, *commands: CommandTopic | None) -> None:
        """Name the topics that the part listens on."""
        self.add_command_topics(*(one.topic for one in commands if one is not None))

    def _add_reader(
        self,
        source: ValueSource | None,
        read_source: Callable[[ValueSource, ReadT, StateMessage], Readings],
        read: ReadT,
    ) -> bool:
        if source is None:
            return False
        if not source.problem:
            self.read_from(source.topic, partial(read_source, source, read))
            return True
        self.read_from(source.topic, partial(_read_raw, source.encoding))
        self.add_capability("raw")
        return False


_CATEGORIES: Mapping[str, Category] = {"": "", "config": "config", "diagnostic": "diagnostic"}
_MAX_RAW = 255
_MAX_ID = 255


def _category(config: DiscoveryConfig) -> Category:
    category = config.text("entity_category")
    if category in _CATEGORIES:
        return _CATEGORIES[category]
    raise WireError(f"{config.component}: entity_category is {shown(category)}, not config or diagnostic")


def _read_source(source: ValueSource, read: Callable[[StateMessage, str], Readings], message: StateMessage) -> Readings:
    text = source.text(message)
    return NO_READINGS if text is None else read(message, text)


def _read_text(source: ValueSource, read: Callable[[str], Readings], message: StateMessage) -> Readings:
    text = source.text(message)
    return NO_READINGS if text is None else read(text)


def _read_raw(encoding: str, message: StateMessage) -> Readings:
    text = message.text(encoding)
    return NO_READINGS if text is None else {"raw": clean_text(text, _MAX_RAW)}
