"""The description of a device that a gateway publishes. Pure."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.description import AutoExpiry, Codec, DescribedPart, DeviceAnnounced, Publication
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, UsageError
from homebot.gateways.announced.announcement import StoredAnnouncement


@dataclass(frozen=True, slots=True)
class GatewayDevice:
    """A device, as the gateway of its protocol describes it.

    Attributes:
        key: The gateway's key for it: unique there, and stable across restarts.
        parts: Its separately usable units; empty if they are unknown.
        identifiers: Identifiers that other gateways know too; see :func:`homebot.devices.identity.identifiers`.
        whole_device: Whether its key is never that of a further device, nor one device's second key: what two such
            devices of the gateway claim identifies neither.
        authenticated: Whether it proved that it belongs to the owner; see :class:`homebot.devices.Sighting`.
        area: Its room, as the protocol reports it; empty for none.
        service_type: Its type in the protocol's own terms; by default the type of its main part.
        address: Where the device itself publishes the state of its main part as plain text (``on``, ``21.5``); by
            default the part's text address, on which the gateway publishes it.
        command_address: Where the device itself accepts plain text; likewise.
        raw_address: The address of its raw messages, in any format; by default *address*, or else its key. Apps that
            read plain text do not receive them.
        stale_after: Seconds of silence after which it counts as stale; 0 for the gateway's default.
        sleeps: Whether it is off the network most of the time to save its battery; it still counts as present.
        expiries: Values that end by themselves, by part id: some motion sensors never report the end of motion.
        codecs: Codecs that show the owner what commands send, by part id; see :class:`ShowingCodec`.
        native: False if another program reports it in a protocol that is not the device's own.
    """

    key: str
    name: str
    parts: tuple[Part, ...] = ()
    metadata: Mapping[str, str] = field(default_factory=dict)
    identifiers: tuple[str, ...] = ()
    whole_device: bool = False
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
        """The address of its raw messages; never the text address that the engine makes."""
        return self.raw_address or self.address or self.key

    def described(self) -> DeviceAnnounced:
        """Return it as an announcement that belongs to no convention."""
        parts = tuple(
            DescribedPart(part, self.codecs.get(part.id, _NO_CODEC), expiries=self.expiries.get(part.id, ()))
            for part in self.parts
        )
        return DeviceAnnounced(
            self.key,
            "",
            self.identifiers,
            self.name,
            parts,
            "",
            self.area,
            self.metadata,
            native=self.native,
            whole_device=self.whole_device,
            stale_after=self.stale_after,
        )

    def complete(self, stored: StoredAnnouncement) -> None:
        """Add the data that announcements lack to *stored*: the device's own addresses."""
        own = {name: getattr(self, name) for name in ("service_type", "address", "command_address")}
        given: dict[str, object] = {name: text for name, text in own.items() if text}
        if self.authenticated:
            given["authenticated"] = True
        if given:
            stored.template = stored.template.model_copy(update=given)


class ShowingCodec:
    """The codec of a part that its gateway reads and writes itself; a subclass can show the messages of commands."""

    def topics(self) -> tuple[str, ...]:
        """Return no topics."""
        return ()

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Readings:
        """Return no values."""
        del topic, payload, retained
        return NO_READINGS

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        """Refuse, so that nothing is shown."""
        del value, transition
        raise RefusedError(capability, "its gateway encodes its messages")


_NO_CODEC = ShowingCodec()


def simple_part(service_type: str, *, settable: tuple[str, ...] = (), readable: tuple[str, ...] = ()) -> Part:
    """Return the only part of a simple device.

    Args:
        service_type: A device type of the vocabulary, for example ``light``.
        settable: Capabilities that can be set and are reported.
        readable: Capabilities that are only reported.

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


def can_report(part: Part, capability: str, value: PlainValue) -> bool:
    """Return whether *part* can report *value* for *capability*; None, for unknown, always can be."""
    known = next(
        (candidate for candidate in part.capabilities if candidate.name == capability and candidate.readable), None
    )
    return known is not None and (value is None or _is_of_kind(CAPABILITIES.get(capability, OWN).kind, value))


def _is_of_kind(kind: str, value: PlainValue) -> bool:
    if kind == "bool":
        return isinstance(value, bool)
    if kind == "number":
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    if kind == "numbers":
        return isinstance(value, tuple) and all(map(math.isfinite, value))
    return isinstance(value, str)
