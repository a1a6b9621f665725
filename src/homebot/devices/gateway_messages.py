"""Messages of gateways: sightings, reports, commands, raw messages and gateway states."""

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field

from homebot.devices.command_messages import Setting
from homebot.devices.device import KeyValue
from homebot.devices.names import is_text_address
from homebot.devices.part import Part
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import Reading, SetBy, Value
from homebot.errors import WireError
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt8

REACHABLE = "reachable"
"""Capability of a whole device (part ``""``): whether it can be reached, according to its convention."""


class Sighting(Message):
    """Announcement of a device by a gateway: it appeared, is still present or described anew, or was removed.

    Attributes:
        key: The gateway's key of the device, or of one announcement of it, which begins with its convention, for
            example ``homeassistant:light/0x17_light``. A device that is announced in several messages or conventions
            has as many keys.
        kind: ``appeared``, ``updated`` (still present, or described anew) or ``removed``.
        name: The name for people; empty if another announcement of the device may name it.
        service_type: The advertised type; for a described device, that of its first part that is neither a setting nor
            a diagnostic.
        address: The address on which it publishes; for a described device, the text address of that part, see
            :func:`homebot.devices.names.text_address`.
        command_address: The address to which it is subscribed; empty if it takes no commands.
        metadata: Further facts, for example ``manufacturer``, ``model``, ``sw_version``, ``via_device``.
        convention: The convention of the announcement; empty if the gateway has only one.
        native: Whether the device, or the bridge that connects it, announced itself in its own convention; this is
            preferred to an announcement by another program.
        whole_device: Whether each announcement of the convention describes a whole device: two announcements are
            different devices unless they name the same radio address.
        identifiers: Identifiers of the device; see :func:`homebot.devices.identity.identifiers`.
        authenticated: Whether the device proved that it is the owner's with a secret that only it and the owner share,
            such as an encryption key. All its other statements about itself are claims.
        parts: Its parts; empty if only its service type is known.
        owns: Topics that belong to the device, with everything below them, because of its place or its bridge rather
            than its announcement; no other device's commands may be sent there.
        announced_on: The address of the announcement (MQTT: the topic); empty if the device only published.
        expires_at: When it becomes stale unless it is seen again; only the gateway knows its protocol's habits.
        confirmed: Whether the device itself published, rather than a retained message.
        heard_at: The time in seconds of the monotonic clock; 0 if the gateway does not state it.
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
        """True if the device publishes text on its own address, as in the thesis's layout."""
        return bool(self.address) and not is_text_address(self.address)


class Report(Message):
    """The values in one message of a device.

    Attributes:
        readings: The values, in the order of the parts.
        address: The address on which they were published (MQTT: the topic); empty if the gateway inferred them.
        stream: The key, the address and the names of the values in one text. The newest report of each stream is kept
            for late joiners; together they are the last known state of the device. Each event is a report in a stream
            of its own, which is not kept, because it happened only once.
        retained: Whether it was a retained message, from the past.
        heard_at: The same time in seconds of the monotonic clock; 0 if the gateway does not state it.
        set_by: Who set the values, if the gateway knows: a ``person`` or a ``program`` past homebot; else empty.
        unreadable: By part, how many payloads it could not read, and the last one with the reason, in words.
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
    set_by: SetBy = ""
    unreadable: tuple[KeyValue, ...] = ()


class Command(Message):
    """Command to set a capability to a value. Always absolute: sending it twice has the effect of sending it once.

    Attributes:
        also: Further settings of the part, for a gateway that can send several in one message.
        transition: Seconds that the change takes, if the device supports that.
        code: The code that an alarm or a lock requires; a secret that no text about the command shows.
        expires_after: Seconds after which the network must no longer deliver it, if it supports that; 0 for never.
        id: The id of the command; empty if no caller awaits the device's answer.
        kept_for: Seconds for which the network may keep it for an unreachable device, because it is sent again
            afterwards; 0 for until it expires.
        repeated: Whether it was sent before without an answer. A network without expiry must deliver it now or never: a
            device that was away would otherwise obey all repetitions when it returns.
        approved: The digest of the description that the owner approved; a gateway whose description of the part has
            changed since refuses the command. Empty if none was approved.
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
    also: tuple[Setting, ...] = ()

    def singly(self) -> Iterator["Command"]:
        """Yield a command for each of its settings."""
        yield self.model_copy(update={"also": ()}) if self.also else self
        for setting in self.also:
            yield self.model_copy(update={"capability": setting.capability, "value": setting.value, "also": ()})


class CommandAnswer(Message):
    """The answer of a device to a command, in a protocol whose devices answer commands some time later.

    Attributes:
        success: Whether the device accepted the command, which does not prove that it obeyed.
    """

    gateway: str
    key: str
    part: str
    capability: str
    command_id: str
    success: bool
    message: str = ""

    @classmethod
    def to(cls, command: Command, gateway: str, problem: str = "") -> "CommandAnswer":
        """Return the answer to *command* of *gateway*: a refusal with its *problem*, or that the device took it."""
        return cls(
            gateway=gateway,
            key=command.key,
            part=command.part,
            capability=command.capability,
            command_id=command.id,
            success=not problem,
            message=problem,
        )


class SendCommandResponse(ServiceAnswer):
    """The gateway's result for a command; it does not prove that the device obeyed.

    Attributes:
        problem: ``refused`` by the part, the gateway or the network, so repeating it is useless; ``unreachable`` if it
            was not sent, because the device or its network cannot be reached now; ``unanswered`` if it was sent but the
            network has not acknowledged it: it may still have an effect.
        unable: Whether it was refused because the part, as described there, cannot do that, or because the owner lets
            the gateway only observe. Nothing was sent, and another route to the part may work.
        along: The capabilities of ``also`` that the same message set; the others are not sent yet.
    """

    problem: Literal["", "refused", "unreachable", "unanswered"] = ""
    unable: bool = False
    along: tuple[str, ...] = ()


SendCommand = ServiceType("homebot/srv/SendCommand", Command, SendCommandResponse)


class RefreshRequest(Message):
    """Request that a gateway ask a part for its values, and a group those of its members.

    The values come as reports, after the answer. A peer that reports only changes reports nothing if there was none.
    """

    key: str
    part: str


class RefreshResponse(ServiceAnswer):
    """Result of a request for values; *message* has the reason if the part was not asked."""


RefreshPart = ServiceType("homebot/srv/RefreshPart", RefreshRequest, RefreshResponse)


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
        issuer: The name of the node that publishes it; empty if unknown.
        command_id: The id from the control layer, which has recorded it in the journal; empty if it did not pass
            through that layer.
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


class RestartGatewayRequest(Message):
    """Request to stop and start a gateway, also one that crashed too often and waits.

    Attributes:
        gateway: Its name.
    """

    gateway: Annotated[str, Field(max_length=200)]


class RestartGatewayResponse(ServiceAnswer):
    """Result of a restart; whether the gateway then works is in its state."""


RestartGateway = ServiceType("homebot/srv/RestartGateway", RestartGatewayRequest, RestartGatewayResponse)


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
