"""Covers and valves: blinds, shutters, gates and doors that a motor moves, and valves with or without a position. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/cover.py`` and ``valve.py``, ``components/valve/__init__.py``.
"""

from collections.abc import Mapping

from homebot.conventions.command_values import Writer, option_writer, percent_writer, require_number, require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.entity_rows import opening_type
from homebot.conventions.payload import NO_READINGS, Readings, fields_of, number_of, unreadable
from homebot.conventions.units import percent_grid
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity, Scale
from homebot.integrations.homeassistant.formats.topics import CommandTopic

_STATES = ("closed", "open", "closing", "opening", "stopped")
"""The later of two states with the same payload counts; a valve has no last one."""


def _scale(config: DiscoveryConfig) -> Scale:
    return Scale(config.integer("position_closed", 0), config.integer("position_open", 100))


def _variables(scale: Scale) -> dict[str, object]:
    return {"position_open": scale.full, "position_closed": scale.zero}


def _payloads(config: DiscoveryConfig, *, stop: str) -> dict[str, str]:
    """Return the payload of each command; a field of null removes it."""
    defaults = {
        "open": ("payload_open", "OPEN"),
        "closed": ("payload_close", "CLOSE"),
        "stopped": ("payload_stop", stop),
    }
    payloads = {state: config.payload(key, default) for state, (key, default) in defaults.items()}
    return {state: payload for state, payload in payloads.items() if payload is not None}


def build_cover(config: DiscoveryConfig) -> DescribedPart:
    """Describe a window covering, or a closure where its class is one."""
    cover = _Cover(config)
    tilt = config.source("tilt_status_topic", "tilt_status_template", cover.variables)
    entity = Entity(config, opening_type(config.values))
    has_position = entity.read_text_from(cover.position, cover.read_position)
    state = entity.usable(cover.state)
    if state is not None:
        entity.read_from(state.topic, cover.read_state)
    has_tilt = entity.read_text_from(tilt, cover.read_tilt)

    move = config.command("command_topic", template_key="")
    payloads = _payloads(config, stop="STOP")
    writer = option_writer("movement", payloads, lambda movement: move.publish(payloads[movement])) if move else None
    entity.add_capability("movement", readable=state is not None or has_position, writer=writer if payloads else None)
    entity.add_commands(move)
    for name, variable, key, scale, readable in (
        ("position", "position", "set_position", cover.scale, has_position),
        ("tilt", "tilt_position", "tilt_command", cover.tilt_scale, has_tilt),
    ):
        command = config.command(f"{key}_topic", f"{key}_template")
        setter = _setter(name, variable, command, scale, cover.variables) if command else None
        entity.add_capability(name, readable=readable, writer=setter, grid=percent_grid(scale.full - scale.zero))
        entity.add_commands(command)
    return entity.build()


_ENDS: Mapping[float | None, str] = {0.0: "closed", 100.0: "open"}
_LEAVES: Mapping[float, str] = {0.0: "opening", 100.0: "closing"}
"""By position: the movement of a cover that leaves an end."""


class _Cover:
    """Reader of a cover's state and position.

    Many covers only report a stopped motor. They are open or closed by their position at an end, which comes in the
    same message, or in one before or after it.
    """

    def __init__(self, config: DiscoveryConfig) -> None:
        self.scale = _scale(config)
        self.tilt_scale = Scale(config.integer("tilt_min", 0), config.integer("tilt_max", 100))
        self.variables = {**_variables(self.scale), "tilt_min": self.tilt_scale.zero, "tilt_max": self.tilt_scale.full}
        self.state = config.source("state_topic")
        self.position = config.source("position_topic", "position_template", self.variables)
        states = {config.text(f"state_{state}", state): state for state in _STATES}
        self._states: Mapping[str, str | None] = {**states, "None": None}
        self._percent: float | None = None  # the last position; None after it began to leave an end
        self._movement: str | None = None
        self._is_settling = False  # stopped, perhaps before the report of its position

    def read_state(self, payload: bytes) -> Readings:
        text = self.state.text(payload) if self.state is not None else None
        if text is None or text not in self._states:
            return unreadable(text, self._states)
        before, self._movement = self._movement, self._states[text]
        movement = self._movement
        if self._percent is not None and movement == _LEAVES.get(self._percent):
            self._percent = None
        self._is_settling = movement == "stopped" and (self._percent is None or before in _LEAVES.values())
        return {"movement": self._stopped(payload) if movement == "stopped" else movement}

    def _stopped(self, payload: bytes) -> str:
        """Return the movement of a stopped cover; by the position in its message, it is closed at 0, or else open."""
        if self.position is None:
            return "stopped"
        if not self._is_of_one_message:
            return _ENDS.get(self._percent, "stopped")
        beside = self.position.text(payload)
        known = self.read_position(beside).get("position") if beside else None
        if known is None:
            return "stopped"
        return "open" if known else "closed"

    @property
    def _is_of_one_message(self) -> bool:
        return self.state is not None and self.position is not None and self.state.topic == self.position.topic

    def read_position(self, text: str) -> Readings:
        """Read the position, and the movement of a cover that reports no state or only that it stopped."""
        value: object = text
        readings: dict[str, PlainValue] = {}
        if text.startswith("{"):
            message = fields_of(text)
            if "position" not in message:
                return NO_READINGS
            readings.update(self.read_tilt(message.get("tilt_position")))
            value = message["position"]
        number = number_of(value)
        if number is None:
            return unreadable(value, "a position")
        self._percent = percent = min(100.0, max(0.0, self.scale.percent(number)))
        readings["position"] = percent
        if self.state is None:
            readings["movement"] = "open" if percent else "closed"
        elif self._is_settling and not self._is_of_one_message:
            readings["movement"] = _ENDS.get(percent, "stopped")
        return readings

    def read_tilt(self, value: object) -> Readings:
        number = number_of(value)
        scale = self.tilt_scale
        if number is None or not min(scale.zero, scale.full) <= round(number) <= max(scale.zero, scale.full):
            return unreadable(value, f"{scale.zero} to {scale.full}")
        return {"tilt": scale.percent(round(number))}


def _setter(name: str, variable: str, command: CommandTopic, scale: Scale, variables: Mapping[str, object]) -> Writer:
    """Return the writer of a percentage, which is also a *variable* of the template."""

    def publish(number: float) -> Publications:
        percent = round(number)
        return command.publish(round(scale.value(percent)), {variable: percent, **variables})

    return percent_writer(name, publish)


def build_valve(config: DiscoveryConfig) -> DescribedPart:
    """Describe a valve, perhaps with a position."""
    valve = _Valve(config)
    entity = Entity(config, "water_valve")
    source = config.source("state_topic", variables=valve.variables)
    readable = entity.read_text_from(source, valve.read_position if valve.has_position else valve.read_state)
    entity.add_capability("valve", readable=readable, writer=valve.move if valve.command else None)
    if valve.has_position:
        writer = valve.set_position if valve.command else None
        entity.add_capability(
            "position", readable=readable, writer=writer, grid=percent_grid(valve.scale.full - valve.scale.zero)
        )
    entity.add_commands(valve.command)
    return entity.build()


_NO_POSITION = ("payload_open", "payload_close", "state_open", "state_closed")
_MOVING = frozenset({"opening", "closing"})


class _Valve:
    """Reader and writer of plain texts and numbers, or of an object with ``state`` and ``position``.

    With a position, open and closed are positions.
    """

    def __init__(self, config: DiscoveryConfig) -> None:
        self.scale = _scale(config)
        self.variables = _variables(self.scale)
        self.has_position = config.flag("reports_position")
        self.command = config.command("command_topic")
        self._payloads = _payloads(config, stop="")
        if not config.has("payload_stop"):
            self._payloads.pop("stopped", None)
        forbidden = next((key for key in _NO_POSITION if key in config.values), "")
        if self.has_position and forbidden:
            raise WireError(f"valve: {forbidden} is not allowed for a valve that reports its position")
        self._states = {config.text(f"state_{state}", state): state for state in _STATES[:-1]}

    def read_state(self, text: str) -> Readings:
        state = fields_of(text).get("state") if text.startswith("{") else text
        if not isinstance(state, str):
            return NO_READINGS
        if state == "None":
            return {"valve": None}
        return {"valve": self._states[state]} if state in self._states else unreadable(state, self._states)

    def read_position(self, text: str) -> Readings:
        state: object = text
        position: object = text
        if text.startswith("{"):
            message = fields_of(text)
            if "position" not in message:
                return NO_READINGS
            state, position = message.get("state"), message["position"]
        if state == "None":
            return {"position": None, "valve": None}
        readings: dict[str, PlainValue] = {}
        number = number_of(position)
        if number is not None:
            percent = min(100.0, max(0.0, self.scale.percent(number)))
            readings = {"position": percent, "valve": "open" if percent else "closed"}
        moving = self._states.get(state) if isinstance(state, str) else None
        if moving in _MOVING:
            readings["valve"] = moving
        return readings or unreadable(position, "a position")

    def move(self, value: PlainValue, transition: float) -> Publications:
        state = require_option("valve", value, self._payloads)
        if self.has_position and state != "stopped":
            return self.set_position(100.0 if state == "open" else 0.0, transition)
        return self.command.publish(self._payloads[state]) if self.command else ()

    def set_position(self, value: PlainValue, _transition: float) -> Publications:
        percent = round(require_number("position", value, 0, 100, "%"))
        variables = {"position": percent, **self.variables}
        return self.command.publish(round(self.scale.value(percent)), variables) if self.command else ()
