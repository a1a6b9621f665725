"""The description of a device that a gateway publishes. Pure."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.command_values import require_bool, require_color, require_number, require_option
from homebot.conventions.description import AutoExpiry, Codec, DescribedPart, DeviceAnnounced, Publication
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Capability, Part
from homebot.devices.text.states import bounds_of
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, UsageError
from homebot.gateways.announced.announcement import StoredAnnouncement

__all__ = ["GatewayDevice", "ShowingCodec", "can_report", "check_command", "simple_part"]


@dataclass(frozen=True, slots=True)
class GatewayDevice:
    """A device in a protocol that describes its devices.

    Attributes:
        key: The gateway's key for it: unique there, and the same after a restart.
        parts: The units that can be used by themselves; a device with unknown parts has none.
        identifiers: See :func:`homebot.devices.identity.identifiers`; identifiers that hold beyond this gateway.
        authenticated: Whether it proved to the gateway that it is the owner's; see :class:`homebot.devices.Sighting`.
        area: The room that it is said to be in; empty for none.
        service_type: Its type in the protocol's own words; by default the type of its main part.
        address: Where it says the state of its main part by itself, as plain text (``on``, ``21.5``) that apps read; by
            default the text address of that part, on which the gateway says it.
        command_address: Where it takes plain text by itself; likewise.
        raw_address: The address of its raw messages, in any format; by default *address*,
            or else its key: apps that read plain text never hear them.
        stale_after: Seconds of silence after which it counts as stale; 0 for the default of the gateway.
        sleeps: Whether it is off the network most of the time, to save its battery; it is there all the same.
        expiries: Values that end by themselves, by the id of the part, such as of a motion sensor that never says that
            all is quiet again.
        codecs: Codecs that only show the owner what commands send, by the id of the part; see :class:`ShowingCodec`.
        native: False where another program tells of it, whose protocol is not the device's own: its own is preferred.
    """

    key: str
    name: str
    parts: tuple[Part, ...] = ()
    metadata: Mapping[str, str] = field(default_factory=dict)
    identifiers: tuple[str, ...] = ()
    authenticated: bool = False
    area: str = ""
    service_type: str = ""
    address: str = ""
    command_address: str = ""
    raw_address: str = ""
    stale_after: float = 0.0
    sleeps: bool = False
    expiries: Mapping[str, tuple[AutoExpiry, ...]] = field(default_factory=dict)
    codecs: Mapping[str, Codec] = field(default_factory=dict)
    native: bool = True

    @property
    def raw(self) -> str:
        """The address on which its raw messages are listened to; never the text address that the engine makes."""
        return self.raw_address or self.address or self.key

    def described(self) -> DeviceAnnounced:
        """Return it as an announcement of no convention."""
        parts = tuple(
            DescribedPart(one, self.codecs.get(one.id, _NO_CODEC), expiries=self.expiries.get(one.id, ()))
            for one in self.parts
        )
        return DeviceAnnounced(
            self.key, "", self.identifiers, self.name, parts, "", self.area, self.metadata, native=self.native
        )

    def complete(self, stored: StoredAnnouncement) -> None:
        """Add to *stored* the data that no announcement has: the device's own addresses and expiry."""
        stored.stale_after = self.stale_after
        own = {name: getattr(self, name) for name in ("service_type", "address", "command_address")}
        given: dict[str, object] = {name: text for name, text in own.items() if text}
        if self.authenticated:
            given["authenticated"] = True
        if given:
            stored.template = stored.template.model_copy(update=given)


class ShowingCodec:
    """The codec of a part that its gateway reads and writes by itself; a subclass can show the messages of commands."""

    def topics(self) -> tuple[str, ...]:
        """Return no topics."""
        return ()

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Readings:
        """Return no values."""
        del topic, payload, retained
        return NO_READINGS

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        """Raise RefusedError, so that nothing is shown."""
        del value, transition
        raise RefusedError(capability, "its gateway encodes its messages")


_NO_CODEC = ShowingCodec()


def simple_part(service_type: str, *, settable: tuple[str, ...] = (), readable: tuple[str, ...] = ()) -> Part:
    """Return the only part of a simple device.

    Args:
        service_type: A device type of the vocabulary, for example ``light``.
        settable: The capabilities that can be set, and are reported.
        readable: Those that are only reported.

    Raises:
        UsageError: The vocabulary has no such type or capability.
    """
    if service_type not in DEVICE_TYPES:
        raise UsageError(f"{service_type!r} is not a device type; known are {', '.join(sorted(DEVICE_TYPES))}")
    for name in (*settable, *readable):
        if name not in CAPABILITIES:
            raise UsageError(f"{name!r} is not a capability; known are {', '.join(sorted(CAPABILITIES))}")
    capabilities = (
        *(Capability(name=name, settable=True) for name in settable),
        *(Capability(name=name) for name in readable),
    )
    return Part(id="", service_type=service_type, capabilities=capabilities)


def check_command(part: Part, capability: str, value: PlainValue) -> None:
    """Check that *capability* of *part* can be set to *value*.

    Raises:
        RefusedError: It cannot; the message names the accepted values.
    """
    found = _settable(part, capability)
    kind = CAPABILITIES.get(capability, OWN).kind
    if kind == "bool":
        require_bool(capability, value)
    elif kind == "number":
        require_number(capability, value, *bounds_of(found), found.unit)
    elif kind == "numbers":
        require_color(value)
    elif found.options:
        require_option(capability, value, found.options)
    elif not isinstance(value, str):
        raise RefusedError(f"{capability} {str(value)[:40]}", "it takes a text")


def can_report(part: Part, capability: str, value: PlainValue) -> bool:
    """Return whether *value* can be one that *part* reports for *capability*; None, for unknown, always can."""
    found = next((one for one in part.capabilities if one.name == capability and one.readable), None)
    return found is not None and (value is None or _is_of_kind(CAPABILITIES.get(capability, OWN).kind, value))


def _settable(part: Part, capability: str) -> Capability:
    found = {one.name: one for one in part.capabilities if one.settable}
    if capability not in found:
        known = ", ".join(found) or "nothing"
        raise RefusedError(f"{capability[:40]} for the part {part.id[:40]!r}", f"this part takes {known}")
    return found[capability]


def _is_of_kind(kind: str, value: PlainValue) -> bool:
    if kind == "bool":
        return isinstance(value, bool)
    if kind == "number":
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    if kind == "numbers":
        return isinstance(value, tuple) and all(map(math.isfinite, value))
    return isinstance(value, str)
