"""Messages of VDA 5050: each robot is a device. Pure."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final, NamedTuple

from homebot.conventions.command_values import option_writer
from homebot.conventions.description import (
    AnnouncementEvent,
    Availability,
    DescribedPart,
    DeviceAnnounced,
    DeviceRequest,
)
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import (
    NO_READINGS,
    JsonMessage,
    Readings,
    as_fields,
    parse_object,
    text_of,
    to_json,
    unreadable,
)
from homebot.devices.identity import identifiers
from homebot.devices.value import PlainValue
from homebot.integrations.vda5050.formats.commands import RobotCommands
from homebot.integrations.vda5050.formats.state import ACTIVITIES, RobotState

_MAX_ROBOTS: Final = 200
"""Further ones are left out, so that no flood pushes out the robots of the house."""

_MAJOR: Final = re.compile(r"v\d{1,3}")

_UNREACHABLE: Final = ("OFFLINE", "CONNECTIONBROKEN", "CONNECTION_BROKEN", "HIBERNATING")
_REACHABLE: Final = {"ONLINE": True, **dict.fromkeys(_UNREACHABLE, False)}
"""By the states of connections of versions 2 and 3, which have two words for the last will."""

_STATES_EVERY: Final = 30.0
"""Seconds; a robot repeats its state at least as often."""


class ConnectionAvailability(NamedTuple):
    """The topic of a robot's connection, its last will; see ``AvailabilitySource``."""

    topic: str

    def read(self, payload: bytes) -> bool | None:
        """Return whether the robot is reachable; None for any other payload."""
        state = as_fields(to_json(payload)).get("connectionState")
        return _REACHABLE.get(state) if isinstance(state, str) else None


class Vda5050Reader:
    """Reader of the messages of robots.

    Args:
        nodes: Where they may be sent; see :class:`homebot.integrations.vda5050.formats.Vda5050Settings`.
        charger: The node where they charge; empty for robots that charge where they stand.

    Attributes:
        rejected: The number of invalid messages.
    """

    def __init__(self, nodes: Mapping[str, tuple[float, ...]], charger: str) -> None:
        self.rejected = 0
        self._nodes, self._charger = nodes, charger
        self._robots: dict[str, tuple[_Robot, DeviceAnnounced]] = {}

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the robot that sent the message; none for a foreign one. Each that connects is asked for its state.

        Raises:
            WireError: It is no JSON object.
        """
        del retained
        base, _, kind = topic.rpartition("/")
        interface, major, maker, serial = base.rsplit("/", 3)
        known = self._robots.get(base)
        is_one_more = known is None and len(self._robots) >= _MAX_ROBOTS
        if not (payload and interface and maker and serial and _MAJOR.fullmatch(major)) or is_one_more:
            return ()
        message = parse_object(payload)
        model = text_of(as_fields(message.get("typeSpecification")).get("seriesName")) if kind == "factsheet" else ""
        robot, announced = known or (_Robot(base, major, self._nodes, self._charger), None)
        if announced is None or (model and announced.facts.get("model") != model):
            announced = self._describe(base, robot, text_of(maker), text_of(serial), model)
        self._robots[base] = robot, announced
        if kind != "connection" or message.get("connectionState") != "ONLINE":
            return (announced,)
        return announced, DeviceRequest(announced.key, robot.commands.request())

    def _describe(self, base: str, robot: _Robot, maker: str, serial: str, model: str) -> DeviceAnnounced:
        return DeviceAnnounced(
            key=f"{maker}/{serial}",
            convention="vda5050",
            identifiers=identifiers([f"{maker}/{serial}"]),
            name=f"{maker} {serial}",
            parts=robot.parts(),
            topic=f"{base}/connection",
            facts={"manufacturer": maker, "serial_number": serial, **({"model": model} if model else {})},
            availability=Availability((ConnectionAvailability(f"{base}/connection"),)),
            owns=(base,),
            implies_alive=True,
            native=True,
            whole_device=True,
            stale_after=4 * _STATES_EVERY,
        )


class _Robot:
    """The parts of one robot, which share its last state."""

    def __init__(self, base: str, major: str, nodes: Mapping[str, tuple[float, ...]], charger: str) -> None:
        self.commands = RobotCommands(base, major, nodes, charger)
        self._topic, self._nodes, self._base = f"{base}/state", tuple(nodes), base
        self._read_last: tuple[JsonMessage, RobotState | None] | None = None

    def parts(self) -> tuple[DescribedPart, ...]:
        """Return the robot itself, its destination, its errors and its position."""
        parts = [self._robot(), self._errors(), *(self._position(axis) for axis in ("x", "y"))]
        return (*parts[:1], *([self._destination()] if self._nodes else []), *parts[1:])

    def _state(self, message: JsonMessage) -> RobotState | None:
        """Return the state in *message*, which all parts read one after the other; None if it came too late."""
        if self._read_last is None or self._read_last[0] is not message:
            state, last = RobotState(message), self.commands.state
            if last is not None and state.header.is_late(last.header):
                unreadable(message.get("headerId"), f"a headerId after {last.header.number}")
                self._read_last = message, None
            else:
                self._read_last, self.commands.state = (message, state), state
        return self._read_last[1]

    def _robot(self) -> DescribedPart:
        part = JsonPart("", "x_robot")
        activities = option_writer("option", ("idle", "working", "paused", "charging"), self.commands.act)
        part.add_capability("option", writer=activities, options=ACTIVITIES)
        for name in ("place", "moving", "problem", "safety", "battery", "battery_charging"):
            part.add_capability(name)
        part.add_command_topics(f"{self._base}/instantActions", f"{self._base}/order")
        part.read_from(self._topic, self._read)
        part.remembers()
        return self._commanded(part)

    def _commanded(self, part: JsonPart) -> DescribedPart:
        return part.build()._replace(refusal=self.commands.refusal)

    def _read(self, message: JsonMessage) -> Readings:
        if (state := self._state(message)) is None:
            return NO_READINGS
        readings: dict[str, PlainValue] = {
            "option": state.activity,
            "place": None if state.is_driving else state.last_node or None,
            "moving": state.is_driving,
            "problem": bool(state.errors),
            "safety": state.is_stopped or state.is_blocked is True,
            "battery": state.charge,
        }
        if state.charging is not None:
            readings["battery_charging"] = state.charging
        return readings

    def _destination(self) -> DescribedPart:
        part = JsonPart("destination", "x_robot", name="Destination", category="config", commands=f"{self._base}/order")
        part.add_command_topics(f"{self._base}/instantActions")
        part.add_capability(
            "option", writer=option_writer("option", self._nodes, self.commands.go), options=self._nodes
        )
        part.read_from(self._topic, self._read_destination)
        return self._commanded(part)

    def _read_destination(self, message: JsonMessage) -> Readings:
        if (state := self._state(message)) is None:
            return NO_READINGS
        return {"option": (state.ahead[-1] if state.ahead else state.last_node) or None}

    def _errors(self) -> DescribedPart:
        part = JsonPart("errors", "x_sensor", name="Errors", category="diagnostic")
        part.add_capability("value")

        def read(message: JsonMessage) -> Readings:
            state = self._state(message)
            return NO_READINGS if state is None else {"value": state.trouble}

        part.read_from(self._topic, read)
        return part.build()

    def _position(self, axis: str) -> DescribedPart:
        part = JsonPart(axis, "x_sensor", name=f"Position {axis}", category="diagnostic")
        part.add_capability("measurement", unit="m")

        def read(message: JsonMessage) -> Readings:
            if (state := self._state(message)) is None:
                return NO_READINGS
            at = state.position
            return {"measurement": None if at is None else round(at.x if axis == "x" else at.y, 2)}

        part.read_from(self._topic, read)
        return part.build()
