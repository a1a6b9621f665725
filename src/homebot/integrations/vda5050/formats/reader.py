"""Messages of VDA 5050: each robot is a device. Pure."""

import re
from collections.abc import Mapping
from typing import Final, NamedTuple

from homebot.conventions.command_values import option_writer
from homebot.conventions.description import AnnouncementEvent, Availability, DescribedPart, DeviceAnnounced
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import JsonMessage, Readings, as_fields, parse_object, text_of, to_json
from homebot.devices.identity import identifiers
from homebot.devices.value import PlainValue
from homebot.integrations.vda5050.formats.commands import RobotCommands
from homebot.integrations.vda5050.formats.state import ACTIVITIES, RobotState

_MAX_ROBOTS: Final = 200
"""Further ones are left out, so that no flood pushes out the robots of the house."""

_MAJOR: Final = re.compile(r"v\d{1,3}")

_REACHABLE: Final = {"ONLINE": True, "OFFLINE": False, "CONNECTIONBROKEN": False, "HIBERNATING": False}
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
        self._robots: dict[str, DeviceAnnounced] = {}

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the robot that sent the message; none for a foreign one.

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
        if known is None or (model and known.facts.get("model") != model):
            known = self._describe(base, major, text_of(maker), text_of(serial), model)
        self._robots[base] = known
        return (known,)

    def _describe(self, base: str, major: str, maker: str, serial: str, model: str) -> DeviceAnnounced:
        robot = _Robot(base, RobotCommands(base, major, self._nodes, self._charger), self._nodes)
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

    def __init__(self, base: str, commands: RobotCommands, nodes: Mapping[str, tuple[float, ...]]) -> None:
        self._topic, self._commands, self._nodes = f"{base}/state", commands, tuple(nodes)
        self._base = base
        self._read_last: tuple[JsonMessage, RobotState] | None = None

    def parts(self) -> tuple[DescribedPart, ...]:
        """Return the robot itself, its destination, its errors and its position."""
        parts = [self._robot(), self._errors(), *(self._position(axis) for axis in ("x", "y"))]
        return (*parts[:1], *([self._destination()] if self._nodes else []), *parts[1:])

    def _state(self, message: JsonMessage) -> RobotState:
        """Return the state in *message*, which all parts read one after the other."""
        if self._read_last is None or self._read_last[0] is not message:
            self._read_last = message, RobotState(message)
        self._commands.state = state = self._read_last[1]
        return state

    def _robot(self) -> DescribedPart:
        part = JsonPart("", "x_robot")
        activities = option_writer("option", ("idle", "working", "paused", "charging"), self._commands.act)
        part.add_capability("option", writer=activities, options=ACTIVITIES)
        for name in ("place", "moving", "problem", "safety", "battery", "battery_charging"):
            part.add_capability(name)
        part.add_command_topics(f"{self._base}/instantActions", f"{self._base}/order")
        part.read_from(self._topic, self._read)
        part.add_state_request(*self._commands.request())
        part.remembers()
        return part.build()

    def _read(self, message: JsonMessage) -> Readings:
        state = self._state(message)
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
            "option", writer=option_writer("option", self._nodes, self._commands.go), options=self._nodes
        )
        part.read_from(self._topic, self._read_destination)
        return part.build()

    def _read_destination(self, message: JsonMessage) -> Readings:
        state = self._state(message)
        return {"option": (state.ahead[-1] if state.ahead else state.last_node) or None}

    def _errors(self) -> DescribedPart:
        part = JsonPart("errors", "x_sensor", name="Errors", category="diagnostic")
        part.add_capability("value")
        part.read_from(self._topic, lambda message: {"value": self._state(message).trouble})
        return part.build()

    def _position(self, axis: str) -> DescribedPart:
        part = JsonPart(axis, "x_sensor", name=f"Position {axis}", category="diagnostic")
        part.add_capability("measurement", unit="m")

        def read(message: JsonMessage) -> Readings:
            at = self._state(message).position
            return {"measurement": None if at is None else round(at.x if axis == "x" else at.y, 2)}

        part.read_from(self._topic, read)
        return part.build()
