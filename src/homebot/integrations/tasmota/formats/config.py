"""The ``config`` message of a Tasmota device, checked, and the topics and commands that follow from it. Pure.

Source: Tasmota 14.4 firmware, ``xdrv_12_discovery.ino``; hatasmota 0.10.2, ``discovery.py``; tasmota.github.io/docs,
MQTT and Commands.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.description import Publication, Publications
from homebot.conventions.payload import JsonMessage, clean_text, parse_object, shown, unreadable
from homebot.errors import InvalidNameError, WireError
from homebot.mqtt.topics import validate_topic

RELAY, LIGHT, SHUTTER = 1, 2, 3
"""Types of an output, besides 0 for none."""


@dataclass(frozen=True, slots=True)
class Tilt:
    """The angles of a shutter's slats at 0 % and at 100 %."""

    least: int
    most: int


@dataclass(frozen=True, slots=True)
class TasmotaConfig:
    """The discovery message of a device.

    Attributes:
        mac: Its hardware address, 12 upper-case digits.
        output_names: Names of its outputs; empty for an output without one.
        result_base: The beginning of its topics of answers.
        telemetry_base: The beginning of its topics of periodic reports.
        state_texts: Its texts for off, on, toggle and hold.
        online: Its payload while it is reachable.
        offline: Its last will.
        outputs: The type of each output; see :data:`RELAY`.
        switch_modes: The mode of each input; -1 for none.
        switch_names: The key of each input in messages.
        buttons: For each button, whether it exists.
        light_type: 0 none or on and off only, 1 dimmer, 2 whites, 3 colours, 4 colours and white, 5 colours and whites.
        is_linked: Whether colours and whites are one lamp.
        is_tuya: Whether another processor drives it.
        is_sleeper: Whether it sleeps most of the time, so that its last will has no meaning.
        shutter_options: Bits for each shutter; 1 inverts its positions.
        tilts: The tilt of each shutter; None for a shutter without.
    """

    mac: str
    name: str
    output_names: tuple[str, ...]
    command_base: str
    result_base: str
    telemetry_base: str
    state_texts: tuple[str, ...]
    online: str
    offline: str
    outputs: tuple[int, ...]
    switch_modes: tuple[int, ...]
    switch_names: tuple[str, ...]
    buttons: tuple[int, ...]
    options: Mapping[int, int]
    light_type: int
    is_linked: bool
    is_tuya: bool
    is_fan: bool
    is_sleeper: bool
    shutter_options: tuple[int, ...]
    tilts: tuple[Tilt | None, ...]
    facts: Mapping[str, str]

    def option(self, number: int) -> bool:
        """Return whether SetOption *number* is on."""
        return bool(self.options.get(number))

    def output_name(self, index: int) -> str:
        """Return the name of an output; empty for none, or for the device's own name."""
        name = self.output_names[index] if index < len(self.output_names) else ""
        return "" if index == 0 and name == self.name else name

    def topic(self, command: str) -> str:
        """Return the topic of a command."""
        return f"{self.command_base}{command}"

    def results(self, *commands: str) -> tuple[str, ...]:
        """Return the topics of the answers to *commands*, on which changes are reported too."""
        answers = commands if self.option(_COMMAND_TOPICS_OPTION) else ("RESULT",)
        return tuple(f"{self.result_base}{answer.upper()}" for answer in answers)

    def states(self, *commands: str) -> tuple[str, ...]:
        """Return the topics of the states that *commands* change: reported at once, and every few minutes."""
        return (*self.results(*commands, "State"), self.telemetry)

    @property
    def own_topics(self) -> tuple[str, ...]:
        """The beginnings of its command topics that its address names: that of the firmware, and its usual one.

        Source: tasmota.github.io/docs, MQTT, "fallback topic".
        """
        tail, base = self.mac[-_TAIL:], self.command_base.removesuffix("/")
        is_named = any(level.upper().endswith(tail) for level in base.split("/"))
        return f"cmnd/DVES_{tail}_fb", *((base,) if is_named else ())

    @property
    def telemetry(self) -> str:
        """The topic on which outputs are reported every few minutes."""
        return f"{self.telemetry_base}STATE"

    @property
    def sensors(self) -> tuple[str, str]:
        """The topics on which sensors are reported: every few minutes, and when requested."""
        return f"{self.telemetry_base}SENSOR", f"{self.result_base}STATUS10"

    @property
    def state_requests(self) -> Publications:
        """Requests of its outputs; none for a sleeping device, which would never receive them."""
        return () if self.is_sleeper else self.publish("STATE")

    @property
    def sensor_requests(self) -> Publications:
        """Requests of its sensors; none for a sleeping device."""
        return () if self.is_sleeper else self.publish("STATUS", 10)

    def publish(self, command: str, argument: str | int = "") -> Publications:
        """Return the publication of one command."""
        return (Publication(self.topic(command), str(argument).encode()),)

    def publish_all(self, commands: list[tuple[str, str | int]]) -> Publications:
        """Return the publication of several commands, executed together."""
        return self.publish("Backlog", ";".join(f"NoDelay;{command} {argument}" for command, argument in commands))

    def state_text(self, on: bool) -> str:  # noqa: FBT001 - the only argument
        """Return its text for on or off."""
        return self.state_texts[1 if on else 0]

    def read_power(self, index: int, message: JsonMessage) -> bool | None:
        """Return whether the output *index* is on; None if the message does not say. A single output has no number."""
        state = message.get(f"POWER{index + 1}", message.get("POWER") if index == 0 else None)
        if isinstance(state, str) and state in self.state_texts[:2]:
            return state == self.state_texts[1]
        unreadable(state, self.state_texts[:2])
        return None


_TAIL = 6
"""Digits of the address in the topic ``tasmota_XXXXXX``, which a device has until its owner gives it another."""

_COMMAND_TOPICS_OPTION = 4
"""SetOption4: the answer to a command has a topic with its name."""


def power_commands(index: int) -> tuple[str, ...]:
    """Return the names by which the output *index* reports its power. A single output has no number."""
    return (f"Power{index + 1}", *(("Power",) if index == 0 else ()))


def sensor_values(message: JsonMessage) -> JsonMessage:
    """Return the sensors in a message: an answer to a request has them in an inner object."""
    inner = message.get("StatusSNS")
    return inner if isinstance(inner, dict) else message


def read_config(mac: str, payload: bytes) -> TasmotaConfig:
    """Return the configuration of the device *mac*, with the firmware's defaults for missing fields.

    Raises:
        WireError: It is not a JSON object, of another version or device, or its topics cannot be topics.
    """
    fields = parse_object(payload)
    if fields.get("ver") != 1:
        raise WireError(f"config: ver is {shown(fields.get('ver'))}, not 1")
    if fields.get("mac") != mac:
        raise WireError(f"config: mac is {shown(fields.get('mac'))}, but it was announced as {shown(mac)}")
    prefixes = _texts(fields, "tp", _MAX_PREFIXES)
    if len(prefixes) != _MAX_PREFIXES or not all(prefixes):
        raise WireError(f"config: tp is {shown(fields.get('tp'))}, not a list of three prefixes")
    names = _texts(fields, "fn", _MAX_INPUTS)
    texts = _texts(fields, "state", len(STATE_TEXTS))
    facts = {fact: clean_text(_text(fields, key)) for fact, key in _FACTS.items()}
    return TasmotaConfig(
        mac=mac,
        name=clean_text(_text(fields, "dn")) or next((name for name in names if name), "") or mac,
        output_names=tuple(clean_text(name) for name in names),
        command_base=_topic(fields, mac, prefixes[0], suffix="/%prefix%"),
        result_base=_topic(fields, mac, prefixes[1]),
        telemetry_base=_topic(fields, mac, prefixes[2]),
        state_texts=texts if len(texts) == len(STATE_TEXTS) and all(texts) else STATE_TEXTS,
        online=_text(fields, "onln") or "Online",
        offline=_text(fields, "ofln") or "Offline",
        outputs=_outputs(fields),
        switch_modes=_numbers(fields.get("swc"), _MAX_INPUTS),
        switch_names=_texts(fields, "swn", _MAX_INPUTS),
        buttons=_numbers(fields.get("btn"), _MAX_INPUTS),
        options=_options(fields.get("so")),
        light_type=_number(fields.get("lt_st")),
        is_linked=fields.get("lk") != 0,
        is_tuya=bool(_number(fields.get("ty"))),
        is_fan=bool(_number(fields.get("if"))),
        is_sleeper=bool(_number(fields.get("dslp"))),
        shutter_options=_numbers(fields.get("sho"), _MAX_OUTPUTS),
        tilts=_tilts(fields.get("sht")),
        facts={"manufacturer": "Tasmota", **{fact: text for fact, text in facts.items() if text}},
    )


STATE_TEXTS = ("OFF", "ON", "TOGGLE", "HOLD")
"""The texts of a device without its own."""

_MAX_PREFIXES = 3
_MAX_OUTPUTS = 64
_MAX_INPUTS = 64
_MAX_OPTIONS = 200
_MAX_TEXT = 255
_TILT_NUMBERS = 3
_FACTS = {"model": "md", "sw_version": "sw", "hostname": "hn", "ip": "ip"}


def _topic(fields: Mapping[str, object], mac: str, prefix: str, *, suffix: str = "") -> str:
    """Return the beginning of a device's topics, up to its last slash, as the firmware makes it.

    Args:
        suffix: What the firmware appends to a topic without prefix.

    Source: Tasmota 14.4 firmware, ``support.ino``, ``GetTopic_P``.
    """
    topic = _text(fields, "ft")
    if not topic:
        raise WireError(f"config: ft is {shown(fields.get('ft'))}, not a topic of at most {_MAX_TEXT} characters")
    topic += "" if "%prefix%" in topic else suffix
    for name, value in (
        ("prefix", prefix),
        ("topic", _text(fields, "t")),
        ("hostname", _text(fields, "hn")),
        ("id", mac),
    ):
        topic = topic.replace(f"%{name}%", value)
    topic = f"{topic.replace('#', '').replace('//', '/').removesuffix('/')}/"
    try:
        validate_topic(topic)
    except InvalidNameError as error:
        raise WireError(f"config: ft gives an invalid topic: {error}") from None
    return topic


def _outputs(fields: Mapping[str, object]) -> tuple[int, ...]:
    outputs = fields.get("rl")
    if not isinstance(outputs, list) or len(outputs) > _MAX_OUTPUTS:
        raise WireError(f"config: rl is {shown(outputs)}, not a list of at most {_MAX_OUTPUTS} outputs")
    return _numbers(outputs, _MAX_OUTPUTS)


def _tilts(value: object) -> tuple[Tilt | None, ...]:
    """Return the tilt of each shutter, from its smallest and largest angle and its time to turn."""
    listed = value[:_MAX_OUTPUTS] if isinstance(value, list) else []
    triples = [_numbers(entry, _TILT_NUMBERS) for entry in listed]
    return tuple(
        Tilt(triple[0], triple[1]) if len(triple) == _TILT_NUMBERS and triple[2] and triple[0] != triple[1] else None
        for triple in triples
    )


_DIGITS = 5


def _options(value: object) -> dict[int, int]:
    listed = list(value.items())[:_MAX_OPTIONS] if isinstance(value, dict) else []
    return {
        int(key): _number(number) for key, number in listed if key.isascii() and key.isdecimal() and len(key) < _DIGITS
    }


def _text(fields: Mapping[str, object], key: str) -> str:
    value = fields.get(key)
    return value if isinstance(value, str) and len(value) <= _MAX_TEXT else ""


def _texts(fields: Mapping[str, object], key: str, most: int) -> tuple[str, ...]:
    """Return the texts of a list, with empty texts for other values."""
    listed = fields.get(key)
    values = listed[:most] if isinstance(listed, list) else []
    return tuple(value if isinstance(value, str) and len(value) <= _MAX_TEXT else "" for value in values)


def _numbers(value: object, most: int) -> tuple[int, ...]:
    return tuple(_number(number) for number in value[:most]) if isinstance(value, list) else ()


def _number(value: object) -> int:
    """Return a small whole number; 0 for any other value."""
    return value if isinstance(value, int) and abs(value) <= _MAX_NUMBER else 0


_MAX_NUMBER = 100_000
