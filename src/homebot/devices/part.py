"""Parts of devices, with their capabilities, the values that these accept, and the description to approve."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from hashlib import blake2b
from operator import attrgetter
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias

from homebot.devices.capabilities import CAPABILITIES, OWN, settable_options
from homebot.devices.value import Value
from homebot.errors import RefusedError
from homebot.messages.message import Message

if TYPE_CHECKING:
    from homebot.devices.value import PlainValue

Category: TypeAlias = Literal["", "config", "diagnostic"]
CodeKind: TypeAlias = Literal["", "digits", "text"]

_EACH = 32
"""The approximate overhead of a text, in bytes."""

_HUE, _SATURATION = 360, 100
_ANY, _TINY, _HALF, _DIGITS = (-1e15, 1e15), 1e-6, 0.5, 9
_COLOR: Final = "hue (0 to 360) and saturation (0 to 100), such as 0,100 for red or 240,50 for pale blue"
"""The accepted values of a colour, the only capability with several numbers."""

_DIGEST_BYTES = 16
_MEMBER: Final = attrgetter("member")


class Capability(Message):
    """One value of a part that can be read, set, or both.

    Attributes:
        name: From the vocabulary, for example ``on_off``; see :data:`homebot.devices.capabilities.CAPABILITIES`.
        readable: Whether the part reports it; if not, its state is unknown (*optimistic*).
        unit: The unit of its values, for example ``°C``; empty if there is none, or it is that of the vocabulary.
        bounds: The smallest and the largest value; empty if unknown.
        options: The texts that it accepts or reports; empty for any.
        grid: One of the numbers that it can be set to, and the step between two of them; empty for any number.
        echoed: Whether its reports are declared to repeat a command before the device obeyed, so that they prove
            nothing.
        code: The characters of the code with which it is set; empty if it needs none. Some values of it may need none.
    """

    name: str
    readable: bool = True
    settable: bool = False
    unit: str = ""
    bounds: tuple[float, ...] = ()
    options: tuple[str, ...] = ()
    grid: tuple[float, ...] = ()
    echoed: bool = False
    code: CodeKind = ""

    def nearest(self, value: float) -> float:
        """Return the number of the grid to which the device rounds *value*; a small level stays on.

        A speed is rounded up, as Home Assistant does, except for less than half a percent: 67 % of three speeds is the
        second. A *value* out of bounds is returned unchanged.
        """
        known = CAPABILITIES.get(self.name, OWN)
        low, high = self.bounds or known.bounds or _ANY
        comparison = known.comparison
        if not self.grid or not low <= value <= high or (comparison.zero_is_off and not value):
            return value
        origin, step = self.grid
        least, most = math.ceil((low - origin) / step - _TINY), math.floor((high - origin) / step + _TINY)
        if most <= least:
            return value  # the step is larger than the range
        if comparison.zero_is_off:
            least = max(least, math.floor(-origin / step + _TINY) + 1)
        steps = (value - origin) / step
        near = math.ceil(steps - _HALF / step) if comparison.rounds_up else math.floor(steps + _HALF + _TINY)
        return round(origin + min(max(near, least), most) * step, _DIGITS)


class SceneValue(Message):
    """The value that a scene sets on one of its members.

    Attributes:
        member: The part, as in :attr:`Part.members`.
    """

    member: str
    capability: str
    value: Value


class Part(Message):
    """One function of a device: a lamp, one of two relays, a thermometer.

    Attributes:
        id: Unique in its device, and permanent; empty for the only part of a simple device.
        name: The name for people, if the part has its own.
        service_type: A device type of the vocabulary, for example ``light``; see
            :data:`homebot.devices.device_types.DEVICE_TYPES`.
        advertised: The type in its announcement's own word, for example ``lights`` or ``cover``.
        tag: The kind within its type, for example ``window`` or ``blind``; empty if none is declared.
        category: ``config`` for a setting, ``diagnostic`` for a diagnostic; empty for a main function.
        guessed: Whether the service type was guessed rather than declared.
        capabilities: The values that it reports and the commands that it accepts.
        reads: The addresses on which it reports (MQTT: topic filters).
        writes: The addresses on which it accepts commands (MQTT: topics).
        payloads: A digest of the command payloads in the announcement; empty if the other fields determine them, as in
            a protocol that leaves no choice.
        members: The parts that its commands set too, as of a group, a room or a scene, or the trackers of a person in
            another system: each the identifier of a device
            for all its parts, with ``#`` and the id of a part for this one; ``#`` and an id alone for a part with an id
            that is unique in its gateway.
        values: The values that a scene sets, if its source tells all of them; empty if it does not.
        fades: Whether its commands take a transition.
    """

    id: str
    name: str = ""
    service_type: str
    advertised: str = ""
    tag: str = ""
    category: Category = ""
    guessed: bool = False
    capabilities: tuple[Capability, ...] = ()
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()
    payloads: str = ""
    members: tuple[str, ...] = ()
    values: tuple[SceneValue, ...] = ()
    fades: bool = False

    @property
    def is_group(self) -> bool:
        """True for a way to reach several parts, such as a group of Zigbee2MQTT: no second lamp beside them."""
        return bool(self.members) and self.service_type not in {"x_scene", "x_tracker"}

    def is_below(self, places: Iterable[str]) -> bool:
        """Return whether one of its topics is in *places* or below one of them."""
        return any(f"{topic}/".startswith(f"{place}/") for place in places for topic in (*self.reads, *self.writes))


def size_of_texts(texts: Iterable[str]) -> int:
    """Return the approximate size of *texts* in bytes."""
    known = texts if isinstance(texts, list) else tuple(texts)
    return len("".join(known)) + _EACH * len(known)


def texts_of(part: Part) -> list[str]:
    """Return the topics, members and options of *part*, which dominate its size."""
    texts = [*part.reads, *part.writes, *part.members, *map(_MEMBER, part.values)]
    for capability in part.capabilities:
        if capability.options:
            texts += capability.options
    return texts


def check_setting(target: str, part: Part, capability: str, value: PlainValue) -> None:
    """Refuse *value* for *capability* if the part does not accept it.

    Args:
        target: The id of the part, for the error.

    Raises:
        RefusedError: The message names the accepted values.
    """
    for offered in part.capabilities:
        if offered.name == capability and offered.settable:
            if not _is_taken(offered, value):
                shown = f"{value:g}" if isinstance(value, float) else f"{value!r:.40}"
                accepted = "True or False" if CAPABILITIES.get(capability, OWN).kind == "bool" else _accepted(offered)
                raise RefusedError(f"{shown} as {capability} of {target}", f"it takes {accepted}")
            return
    known = ", ".join(dict.fromkeys(offered.name for offered in part.capabilities if offered.settable))
    raise RefusedError(
        f"{capability} of {target}", f"it has no such setting; it takes {known}" if known else "it takes no commands"
    )


def check_no_share(target: str, capability: str, value: float, exactly: str) -> None:
    """Refuse a share of 1 that is given as a percentage, such as 0.4; one with more than two decimals is computed.

    Args:
        exactly: How to set the value as it is.

    Raises:
        RefusedError: The message asks for the percentage.
    """
    is_percentage = CAPABILITIES.get(capability, OWN).unit == "%" and isinstance(
        value, float
    )  # else it is refused later
    if is_percentage and 0 < value < 1 and round(value, 2) == value:
        asked = f"it takes percent; did you mean {100 * value:g} %? To set {value:g} %: {exactly}"
        raise RefusedError(f"{value:g} as {capability} of {target}", asked)


def accepted_values(part: Part, capability: str) -> str:
    """Return the values that *part* accepts for *capability*, in words; empty if it cannot be set."""
    for offered in part.capabilities:
        if offered.name == capability and offered.settable:
            return _accepted(offered)
    return ""


def _accepted(capability: Capability) -> str:
    known = CAPABILITIES.get(capability.name, OWN)
    if options := capability.options or known.options:
        return ", ".join(settable_options(capability.name, options))
    match known.kind:
        case "bool":
            return "on or off"
        case "numbers":
            return _COLOR
        case "number":
            bounds, unit = capability.bounds or known.bounds, capability.unit or known.unit
            steps = f" in steps of {capability.grid[1]:.3g}" if capability.grid else ""
            return f"{bounds[0]:g} to {bounds[1]:g} {unit}".rstrip() + steps if bounds else "a finite number"
    return "a text"


def _is_taken(capability: Capability, value: PlainValue) -> bool:
    """Return whether *value* has the right kind for *capability* and is accepted; an unknown capability accepts any."""
    known = CAPABILITIES.get(capability.name, OWN)
    kind = known.kind
    match value:
        case bool():
            return kind in ("bool", "")
        case float():
            bounds = capability.bounds or known.bounds
            return kind in ("number", "") and math.isfinite(value) and (not bounds or bounds[0] <= value <= bounds[1])
        case str():
            return kind in ("text", "") and (
                not capability.options or value in settable_options(capability.name, capability.options)
            )
        case (float() | int() as hue, float() | int() as saturation):
            return kind in ("numbers", "") and 0 <= hue <= _HUE and 0 <= saturation <= _SATURATION
    return False


def payload_digest(announced: object) -> str:
    """Return the digest of *announced*, the plain values that determine the payloads of commands."""
    return blake2b(repr(announced).encode(errors="surrogatepass"), digest_size=_DIGEST_BYTES).hexdigest()


class CommandDescription(NamedTuple):
    """Announced facts about the commands of a part.

    Attributes:
        identifiers: The identifiers of the device, sorted.
        payloads: See :attr:`homebot.devices.part.Part.payloads`.
    """

    service_type: str
    identifiers: tuple[str, ...]
    topics: tuple[str, ...]
    settings: tuple[str, ...]
    payloads: str

    @classmethod
    def of(cls, part: Part, identifiers: tuple[str, ...]) -> CommandDescription:
        """Return the description of *part*, announced with the *identifiers* of its device."""
        settings = tuple([capability.name for capability in part.capabilities if capability.settable])
        return cls(part.service_type, tuple(sorted(identifiers)), part.writes, settings, part.payloads)

    @property
    def digest(self) -> str:
        """Digest of all fields."""
        return payload_digest(tuple(self))

    def changes(self, before: CommandDescription) -> str:
        """Return the differences from *before* as text; empty if there are none."""
        return "; ".join(self._changes(before))

    def _changes(self, before: CommandDescription) -> Iterator[str]:
        if self.service_type != before.service_type:
            yield f"its type is {self.service_type}, it was {before.service_type}"
        for name, now, then in (
            ("its commands go to", self.topics, before.topics),
            ("it takes", self.settings, before.settings),
            ("its identifiers are", self.identifiers, before.identifiers),
        ):
            if now != then:
                yield f"{name} {_list(now)} instead of {_list(then)}"
        if self.payloads != before.payloads:
            yield "the payloads of its commands changed"


_MAX_LISTED = 5
_MAX_CHARACTERS = 100


def _list(words: tuple[str, ...]) -> str:
    shown = ", ".join([word[:_MAX_CHARACTERS] for word in words[:_MAX_LISTED]])
    return (f"{shown}, …" if len(words) > _MAX_LISTED else shown) or "none"
