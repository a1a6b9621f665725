"""Descriptions of single things, on tags, in codes and in files, in the format that an integration offers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Protocol

from homebot.devices.device import Device
from homebot.errors import WireError
from homebot.plugins import has_plugin, load_plugin

_GROUP: Final = "homebot.thing_formats"
_NAME: Final = "td"


@dataclass(frozen=True, slots=True)
class DescribedThing:
    """The content of a description; a text is empty where it says nothing."""

    id: str = ""
    title: str = ""
    area: str = ""
    identifiers: tuple[str, ...] = ()
    facts: Mapping[str, str] = field(default_factory=dict)


class ThingFormat(Protocol):
    """A format of descriptions, as JSON values."""

    def read(self, document: object) -> DescribedThing:
        """Return the thing that *document* describes.

        Raises:
            WireError: It is invalid.
        """
        ...

    def describe(self, device: Device, brokers: Mapping[str, str]) -> dict[str, object]:
        """Return the description of *device*, whose gateways have *brokers* by their names."""
        ...


def thing_format() -> ThingFormat:
    """Return the installed format.

    Raises:
        PluginError: None is installed.
    """
    made: ThingFormat = load_plugin(_GROUP, _NAME)()
    return made


def read_thing(document: object) -> DescribedThing:
    """Return the thing that *document* describes in the installed format.

    Raises:
        WireError: It is invalid, or no format is installed.
    """
    if not has_plugin(_GROUP, _NAME):
        raise WireError("descriptions of things are not read here")
    return thing_format().read(document)
