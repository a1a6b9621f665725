"""MQTT as the way to reach devices that Thing Descriptions tell of. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final
from urllib.parse import quote

from homebot.devices.device import DevicePart, Endpoint, Route
from homebot.devices.names import read_text_address
from homebot.devices.part import Capability
from homebot.wot.payload import TEXT_CONTENT_TYPE

__all__ = ["MqttForms", "own_content_type"]

_NO_ROUTE: Final = Route(gateway="", key="", part="")
_LOCAL: Final = "mqtt://localhost:1883"
_IN_PATH: Final = "/!$&'()*+,:;=@"  # RFC 3986, section 3.3


def own_content_type(convention: str) -> str:
    """Return the content type of payloads that a convention spells; without one they are plain words."""
    return f"application/vnd.homebot.{convention or 'words'}"


class MqttForms:
    """The topics of devices.

    Where a convention such as Zigbee2MQTT's says how payloads are spelt, the content type names it.

    Args:
        brokers: Address of each gateway's broker, for example ``mqtt://192.168.1.10:1883``; any other is taken to be
            ``mqtt://localhost:1883``.
    """

    def __init__(self, brokers: Mapping[str, str]) -> None:
        self._brokers = brokers

    def of_property(self, _name: str, part: DevicePart, capability: Capability) -> list[dict[str, object]]:
        """Return the forms of a property: the topics of its part."""
        best = part.routes[0] if part.routes else _NO_ROUTE
        broker, content = self._brokers.get(best.gateway, _LOCAL), own_content_type(best.convention)
        forms: list[dict[str, object]] = []
        if capability.readable:
            forms += [_form(broker, content, observed=topic) for topic in part.part.reads]
        if capability.settable:
            forms += [_form(broker, content, written=topic) for topic in part.part.writes]
        return forms

    def of_words(self, endpoint: Endpoint) -> list[dict[str, object]]:
        """Return the forms for plain text: the topics of the device."""
        broker = self._brokers.get(endpoint.gateway, _LOCAL)
        forms: list[dict[str, object]] = []
        if endpoint.address and read_text_address(endpoint.address) is None:
            forms.append(_form(broker, TEXT_CONTENT_TYPE, observed=endpoint.address))
        if endpoint.command_address and read_text_address(endpoint.command_address) is None:
            forms.append(_form(broker, TEXT_CONTENT_TYPE, written=endpoint.command_address))
        return forms


def _form(broker: str, content: str, *, observed: str = "", written: str = "") -> dict[str, object]:
    """Return a form to observe rather than to read: whether the broker retains it is not known.

    The topic is in the address as well: consumers such as node-wot look for it there alone.
    """
    href = f"{broker.rstrip('/')}/{quote(observed or written, safe=_IN_PATH)}"
    if observed:
        return {
            "href": href,
            "contentType": content,
            "op": ["observeproperty", "unobserveproperty"],
            "mqv:controlPacket": "subscribe",
            "mqv:filter": observed,
        }
    return {
        "href": href,
        "contentType": content,
        "op": "writeproperty",
        "mqv:controlPacket": "publish",
        "mqv:topic": written,
    }
