"""Settings of one robot: a table ``[robots.NAME]``; and its pose as JSON."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Self, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from homebot.config import Table, parse_settings
from homebot.devices.robot_owners import MAP, check_robot_name
from homebot.errors import ConfigError, UsageError
from homebot.units import Seconds

_Metres: TypeAlias = Annotated[float, Field(ge=-10_000, le=10_000, allow_inf_nan=False)]
_Radians: TypeAlias = Annotated[float, Field(ge=-7, le=7, allow_inf_nan=False)]
_Frame: TypeAlias = Annotated[str, AfterValidator(lambda frame: frame.removeprefix("/"))]
_Limit: TypeAlias = Annotated[Seconds, Field(le=3600)]


class RobotSettings(BaseModel):
    """The keys of a table ``[robots.NAME]``, which may be empty for a robot that publishes its own pose.

    Attributes:
        frames: Its frames on ``/tf`` that do not begin with its name and a slash; not needed for a single robot.
        floor: Its floor; not needed in a house with one floor.
        limit: Seconds for which a pose from ``/NAME/pose`` or MQTT is valid.
        topic: An MQTT topic with its pose as JSON: ``x``, ``y``, and any of ``yaw``, ``error``, ``floor`` and
            ``limit``; or only ``room``. Retained messages do not count, as their age is not known. A topic may also
            have poses in a form that an integration reads, such as the ``state`` of a robot of VDA 5050.
        vacuum: The MQTT topic of a vacuum cleaner with a map, such as ``valetudo/NAME``.
        segments: The rooms of the segments on its map, by id: ``{"16" = "Kitchen"}``; or of the destinations of a robot
            of a fleet.
        map_transform: x, y in metres and yaw in radians of the frame of its map, ``NAME/map``, in the house's frame
            ``map``. Not needed if three of its segments have the names of rooms with a polygon.
        gateway: The gateway that receives ``topic`` and ``vacuum``.
        motion_sensors: The names or ids of motion sensors that detect only this robot: it is in their room for a
            minute.
        tag_reader: The NFC reader on the robot: it is in the room of each tag that it reads, for ten minutes.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    frames: tuple[_Frame, ...] = ()
    floor: str = ""
    limit: _Limit = 5.0
    topic: str = ""
    vacuum: str = ""
    segments: Mapping[str, str] = Field(default_factory=dict)
    map_transform: tuple[_Metres, _Metres, _Radians] | None = None
    gateway: str = "mqtt"
    motion_sensors: tuple[str, ...] = ()
    tag_reader: str = ""


def read_robots(tables: Mapping[str, Table], source: str, folder: Path) -> dict[str, RobotSettings]:
    """Return the robots by name.

    Raises:
        ConfigError: A table is wrong, a robot cannot have its name, or two have one frame.
    """
    robots: dict[str, RobotSettings] = {}
    owners = {MAP: "the house"}
    for name, table in tables.items():
        key = f"robots.{name}"
        try:
            check_robot_name(name)
        except UsageError as exc:
            raise ConfigError(source, key, str(exc)) from exc
        robots[name] = parse_settings(RobotSettings, table, source, key, folder)
        for frame in robots[name].frames:
            if (owner := owners.setdefault(frame, f"the robot {name}")) != f"the robot {name}":
                raise ConfigError(source, f"{key}.frames", f"{frame!r} is a frame of {owner} already")
    return robots


class JsonPose(BaseModel):
    """A pose on the ``topic`` of a robot; other keys are ignored."""

    model_config = ConfigDict(strict=True, defer_build=True)

    x: _Metres | None = None
    y: _Metres | None = None
    yaw: _Radians = 0.0
    error: Annotated[float, Field(ge=0, le=1000)] = 0.5
    floor: str = ""
    room: str = ""
    limit: _Limit | None = None

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        if (self.x is None or self.y is None) and not self.room:
            raise ValueError("it has neither x and y nor a room")
        return self
