"""One component of a Shelly of the second generation: its topics, its calls and its part. Pure.

A component reports on three topics: its whole status on ``<prefix>/status/<component>`` and in the answer to
``Shelly.GetStatus``, or to ``Shelly.GetComponents`` if it was added later, and changes on ``<prefix>/events/rpc``.

Source: Shelly Gen2+ API, General, RPC Protocol, RPC Channels (MQTT), Notifications.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, Unpack

from homebot.conventions.command_values import Writer, bool_writer, number_writer, option_writer
from homebot.conventions.description import Publication, Publications
from homebot.conventions.part_builder import JsonPart, PartFields
from homebot.conventions.payload import NO_READINGS, Readings, as_fields, compact_json, shown, text_of
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.shelly.formats.status import (
    MAX_TEXT_CHARACTERS,
    NO_FIELDS,
    Fields,
    StatusDecoder,
    reader_of,
    value_at,
)


def call(prefix: str, source: str, method: str, params: Mapping[str, object] | None = None) -> Publication:
    """Return the call of *method* of the device at *prefix*; it answers on ``<source>/rpc``."""
    frame: dict[str, object] = {"id": 1, "src": source, "method": method}
    if params is not None:
        frame["params"] = params
    return Publication(f"{prefix}/rpc", compact_json(frame).encode())


COMPONENTS = "Shelly.GetComponents"
"""The method of the components that the other answers lack; its answer comes in pages."""


def components_from(offset: int) -> Mapping[str, object]:
    """Return the parameters of :data:`COMPONENTS` for the page that begins at *offset*."""
    return {"dynamic_only": True, "include": ["status", "config"], "offset": offset}


def page_name(offset: int) -> str:
    """Return the key of a page of the answer to ``Shelly.GetComponents`` in the sizes of answers."""
    return f"components from {offset}"


BLUETOOTH: Final = ("blutrv", "bthomesensor", "bthomedevice")
"""The components of Bluetooth devices; answers have what the Shelly last received of them."""

PRESSES: Final[Mapping[str, str]] = {
    "single_push": "single",
    "double_push": "double",
    "triple_push": "triple",
    "long_push": "long",
}
"""Events of a button, in the words of the vocabulary."""

MAX_UNIT_CHARACTERS: Final = 20
_ANY_NUMBER = (-1e15, 1e15)


@dataclass(frozen=True, slots=True)
class Gen2Topics:
    """The topics of a device of the second generation.

    Attributes:
        prefix: The beginning of its topics.
        source: The client id of homebot's calls; they are answered on ``<source>/rpc``.
        answers: The topic of answers to requests for its state.
        is_plug: Whether its relays are sockets.
    """

    prefix: str
    source: str
    answers: str
    is_plug: bool = False


@dataclass(frozen=True, slots=True)
class ShellyComponent:
    """One component.

    Attributes:
        key: Its name, for example ``switch:0``.
        status: The answer to the last request of its status.
        config: Its configuration; empty if unknown.
        load: The load in the user's settings, such as ``light``; empty for none.
        is_inside: Whether it measures the device itself and not its surroundings.
    """

    topics: Gen2Topics
    key: str
    status: Fields
    config: Fields = field(default_factory=dict)
    load: str = ""
    is_inside: bool = False

    @property
    def kind(self) -> str:
        """Type of the component, for example ``switch``."""
        return self.key.partition(":")[0]

    @property
    def index(self) -> int:
        """Number among the components of its type."""
        return int(self.key.partition(":")[2] or 0)

    @property
    def name(self) -> str:
        """Name in its configuration; empty for none."""
        return text_of(self.config.get("name"))

    @property
    def commands(self) -> str:
        """The topic of its commands."""
        return f"{self.topics.prefix}/rpc"

    def has(self, path: str) -> bool:
        """Return whether its status has a value at *path*."""
        return value_at(self.status, path) is not NO_FIELDS

    def part(self, suffix: str, service_type: str, **fields: Unpack[PartFields]) -> JsonPart:
        """Return a part without capabilities; its *suffix* is empty for the main part of the component."""
        part_id = f"{self.key}/{suffix}" if suffix else self.key
        fields["name"], fields["advertised"] = f"{self.name} {fields.get('name', '')}".strip(), self.kind
        return JsonPart(part_id, service_type, commands=self.commands, **fields)

    def read_status(self, part: JsonPart, decode: StatusDecoder, key: str = "") -> None:
        """Read the component, or the one called *key*, with *decode*."""
        key = key or self.key
        prefix = self.topics.prefix
        part.read_from(f"{prefix}/events/rpc", lambda frame: _read(as_fields(frame.get("params")), key, decode))
        part.read_from(f"{prefix}/status/{key}", decode)
        answered = _skip_repeated(decode) if self.kind in BLUETOOTH else decode
        part.read_from(self.topics.answers, lambda frame: _read_answer(as_fields(frame.get("result")), key, answered))

    def add_value(
        self,
        part: JsonPart,
        capability: str,
        path: str = "value",
        method: str = "",
        param: str = "value",
        *,
        factor: float = 1.0,
        key: str = "",
        unit: str = "",
        bounds: tuple[float, ...] = (),
        grid: tuple[float, ...] = (),
        options: tuple[str, ...] = (),
        **more: object,
    ) -> None:
        """Add *capability*, the value at *path*, of the kind that the vocabulary has; see :func:`reader_of`.

        Args:
            method: The method that sets it; empty if it is not settable.
            param: The parameter of *method* with the value; *more* are its other ones.
            key: The name of another component that reports it; empty for this one.
        """
        self.read_status(part, reader_of(path, capability, factor), key)
        writer = None
        if method:
            writer = _writer(capability, bounds, options, lambda value: self.call(method, **more, **{param: value}))
        part.add_capability(capability, writer=writer, unit=unit, bounds=bounds, grid=grid, options=options)

    def add_presses(self, part: JsonPart, presses: Mapping[str, str], index: int | None = None) -> None:
        """Add ``press``, read from the component's events, which *presses* translates.

        Args:
            index: The number of the button; None for the events of all.
        """
        key = self.key
        part.read_events_from(
            f"{self.topics.prefix}/events/rpc", lambda frame: _read_events(frame, key, presses, index)
        )
        part.add_capability("press", options=tuple(presses.values()))

    def call(self, method: str, /, **params: object) -> Publications:
        """Return the call of *method* of this component."""
        return (call(self.topics.prefix, self.topics.source, method, {"id": self.index, **params}),)


def _writer(
    capability: str, bounds: tuple[float, ...], options: tuple[str, ...], publish: Callable[[object], Publications]
) -> Writer:
    match CAPABILITIES[capability].kind:
        case "bool":
            return bool_writer(capability, publish)
        case "number":
            return number_writer(
                capability,
                bounds or _ANY_NUMBER,
                "",
                lambda number: publish(int(number) if number.is_integer() else number),
            )
    if options:
        return option_writer(capability, options, publish)

    def write_text(value: PlainValue, _transition: float) -> Publications:
        if isinstance(value, str) and len(value) <= MAX_TEXT_CHARACTERS and value.isprintable():
            return publish(value)
        raise RefusedError(
            f"{capability} {shown(value)}", f"it takes a text of at most {MAX_TEXT_CHARACTERS} characters"
        )

    return write_text


def _skip_repeated(decode: StatusDecoder) -> StatusDecoder:
    """Return *decode* without a status that comes again: nothing was received since."""
    last: Fields = NO_FIELDS

    def read(status: Fields) -> Readings:
        nonlocal last
        before, last = last, status
        return NO_READINGS if status == before else decode(status)

    return read


def _read(components: Fields, key: str, decode: StatusDecoder) -> Readings:
    status = components.get(key)
    return decode(status) if isinstance(status, dict) else NO_READINGS


def _read_answer(result: Fields, key: str, decode: StatusDecoder) -> Readings:
    listed = result.get("components")
    if not isinstance(listed, list):
        return _read(result, key, decode)
    component = next((fields for fields in map(as_fields, listed) if fields.get("key") == key), NO_FIELDS)
    return _read({key: component.get("status")}, key, decode)


_MAX_EVENTS = 32


def _read_events(frame: Fields, key: str, presses: Mapping[str, str], index: int | None) -> Readings:
    events = as_fields(frame.get("params")).get("events")
    if not isinstance(events, list):
        return NO_READINGS
    readings: dict[str, PlainValue] = {}
    for event in events[:_MAX_EVENTS]:
        fields = as_fields(event)
        is_own = fields.get("component") == key and index in {None, fields.get("idx", 0)}
        name = fields.get("event") if is_own else None
        if isinstance(name, str) and name in presses:
            readings["press"] = presses[name]
    return readings
