"""Messages of gateways: sightings, reports, commands, raw messages and their own state."""

from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field

from homebot.devices.device import KeyValue
from homebot.devices.names import is_text_address
from homebot.devices.part import Part
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import Reading, Value
from homebot.errors import WireError
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt8

__all__ = [
    "REACHABLE",
    "Command",
    "CommandAnswer",
    "GatewayState",
    "RawCommand",
    "RawMessage",
    "Report",
    "SendCommand",
    "SendCommandResponse",
    "Sighting",
]


REACHABLE = "reachable"
"""Capability of a whole device (part ``""``): whether it can be reached, by its convention."""


class Sighting(Message):
    """Announcement of a device by a gateway: it appeared, is still there or described anew, or was removed.

    Attributes:
        key: The gateway's key of the device, or of one announcement of it, then beginning with its convention, for
            example ``homeassistant:light/0x17_light``: a device that is announced in several messages, or through
            several conventions, has as many keys.
        kind: ``appeared``, ``updated`` (still there, or described anew) or ``removed``.
        name: The name for people; empty if another announcement of the device may name it.
        service_type: The advertised type; of a described device that of the first part that is neither setting nor
            diagnosis.
        address: The address on which it publishes; of a described device the text address of that part, see
            :func:`homebot.devices.names.text_address`.
        command_address: The address to which it is subscribed; empty when it takes no commands.
        metadata: Further facts, for example ``manufacturer``, ``model``, ``sw_version``, ``via_device``.
        convention: The convention of the announcement; empty if there is one only.
        native: Whether the device, or the bridge that connects it, announced itself in a convention of its own: that is
            preferred to an announcement of another program.
        whole_device: Whether each announcement of the convention is of a whole device: two of them are never about the
            same one, unless they name one radio address.
        identifiers: Identifiers of the device; see :func:`homebot.devices.identity.identifiers`.
        authenticated: Whether the device proved to the gateway that it is one of the owner's, by a secret that it
            shares with the owner alone, such as an encryption key. All else that it says of itself is a claim.
        parts: Its parts; empty if only its service type is known.
        owns: Topics that the device has for itself with all that is below them, by its own place or by its bridge
            rather than by its announcement; no other device may send commands there.
        announced_on: The address of the announcement (MQTT: the topic); empty if it only published.
        expires_at: The time at which it becomes stale unless it is seen again; the gateway alone knows its protocol's
            habits.
        confirmed: Whether the device itself published, rather than a retained message.
        heard_at: The time in seconds of the monotonic clock, which is never set; 0 if the gateway does not give it.
    """

    key_field: ClassVar[str | None] = "key"

    gateway: str
    key: str
    kind: Literal["appeared", "updated", "removed"]
    why: str
    name: str
    service_type: str
    address: str
    command_address: str
    metadata: tuple[KeyValue, ...] = ()
    convention: str = ""
    native: bool = False
    whole_device: bool = False
    identifiers: tuple[str, ...] = ()
    authenticated: bool = False
    area: str = ""
    parts: tuple[Part, ...] = ()
    owns: tuple[str, ...] = ()
    announced_on: str = ""
    seen_at: Time
    expires_at: Time
    confirmed: bool
    heard_at: float = 0.0

    @property
    def is_plain_text(self) -> bool:
        """True if it publishes text on an address of its own, as in the thesis's layout."""
        return bool(self.address) and not is_text_address(self.address)


class Report(Message):
    """The values in one message of a device.

    Attributes:
        readings: The values, in the order of the parts.
        address: The address on which they were published (MQTT: the topic); empty for a conclusion of the gateway.
        stream: Key, address and names of the values in one. The newest report of each is kept for late joiners, so that
            together they are all that the device reported. Events have reports of their own, each in a stream of its
            own that is not kept: they happened once.
        retained: Whether it was a retained message, of the past.
        heard_at: The same in seconds of the monotonic clock, which is never set; 0 if the gateway does not give it.
    """

    key_field: ClassVar[str | None] = "stream"

    gateway: str
    key: str
    readings: tuple[Reading, ...]
    address: str = ""
    stream: str = ""
    retained: bool
    received_at: Time
    heard_at: float = 0.0


class Command(Message):
    """Order to set a capability to a value. Always absolute: sending it twice has the effect of sending it once.

    Attributes:
        transition: Seconds that the change takes, if the device supports that.
        code: The code that an alarm or a lock requires; a secret, which no text about the command shows.
        expires_after: Seconds after which the network is not to deliver it any more, if it supports that; 0 for never.
        id: The id of the command; empty if no caller waits for the device's answer.
        kept_for: Seconds for which the network may keep it for a device that is away, as it is sent again after that;
            0 for until it expires.
        repeated: Whether it was sent before without an answer. A network in which nothing expires delivers it now or
            never: a device that was away would obey all repetitions when it is back.
        approved: The digest of the description that the owner approved; a gateway that has another description of the
            part by now refuses the command. Empty if none was approved.
        topics: See :attr:`homebot.devices.device.Route.topics`; a gateway that has others by now refuses the command,
            as they may be those of another device. Empty if they are not known.
    """

    model_config = ConfigDict(hide_input_in_errors=True)

    key: str
    part: str
    capability: str
    value: Value
    transition: float = 0.0
    code: Annotated[str, Field(repr=False, max_length=255)] = ""
    expires_after: Annotated[float, Field(ge=0.0)] = 0.0
    id: str = ""
    kept_for: Annotated[float, Field(ge=0.0)] = 0.0
    repeated: bool = False
    approved: str = ""
    topics: tuple[str, ...] = ()


class CommandAnswer(Message):
    """The answer of a device to a command, in a protocol in which devices answer commands some time later.

    Attributes:
        success: Whether the device accepted the command; that is no proof that it obeyed.
    """

    gateway: str
    key: str
    part: str
    capability: str
    command_id: str
    success: bool
    message: str = ""


class SendCommandResponse(ServiceAnswer):
    """The gateway's result for a command; it does not prove that the device obeyed.

    Attributes:
        problem: ``refused`` by the part, the gateway or the network, where the same again fails again; ``unreachable``
            if it was not sent, as the device or its network cannot be reached now; ``unanswered`` if it was sent, and
            the network has not acknowledged it: it may still have its effect.
        unable: Whether it was refused because the part cannot do that as it is described there. Nothing was sent then,
            and another route to the part may do.
    """

    problem: Literal["", "refused", "unreachable", "unanswered"] = ""
    unable: bool = False


SendCommand = ServiceType("homebot/srv/SendCommand", Command, SendCommandResponse)


class RawMessage(Message):
    """A raw message of a device, as received.

    Attributes:
        address: The address on which it was published (MQTT: the topic).
    """

    gateway: str
    key: str
    address: str
    payload: bytes
    retained: bool
    received_at: Time

    def text(self) -> str:
        """Return the payload as text.

        Raises:
            WireError: It is not UTF-8; the message names the address.
        """
        try:
            return self.payload.decode()
        except UnicodeDecodeError as exc:
            raise WireError(f"the payload on {self.address} is not text", self.payload) from exc


class RawCommand(Message):
    """A payload for a device.

    Attributes:
        address: The address to publish it on (MQTT: the topic).
        payload: The text, sent as UTF-8.
        issuer: The name of the node that publishes it; empty if that is not known.
        command_id: The id that the control layer gave it, which has noted it in the journal; empty if it did not
            pass there.
        approved, topics: As those of a :class:`Command`, if it is a text for a part.
    """

    address: str
    payload: str
    qos: Annotated[UInt8, Field(le=2)] = 1
    retain: bool = False
    issuer: str = ""
    trigger: Trigger = NO_TRIGGER
    command_id: str = ""
    approved: str = ""
    topics: tuple[str, ...] = ()


class GatewayState(Message):
    """The state of a gateway: whether it is connected to its network, and whether it sends commands.

    Attributes:
        state: ``active`` or ``unavailable``.
        reason: The reason why it is unavailable, as text.
        acts: Whether it sends commands; a gateway that only observes refuses them.
    """

    state: Literal["active", "unavailable"]
    reason: str
    acts: bool
