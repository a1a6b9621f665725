"""VDA 5050 as a convention. Pure.

Source: VDA 5050 2.1 and 3.0, "MQTT topic levels".
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Self, TypeAlias

from pydantic import AfterValidator, BaseModel, Field, model_validator

from homebot.conventions.convention import ConventionSettings, LazyConvention, TopicPrefix

if TYPE_CHECKING:
    from homebot.integrations.vda5050.formats.reader import Vda5050Reader

__all__ = ["Vda5050", "Vda5050Settings"]


def _check_position(position: tuple[float, ...]) -> tuple[float, ...]:
    if len(position) not in {0, 2, 3}:
        raise ValueError("a node is [] or [x, y] or [x, y, theta], in metres and radians")
    return position


_Metres: TypeAlias = Annotated[float, Field(ge=-10_000, le=10_000, allow_inf_nan=False)]
_Position: TypeAlias = Annotated[tuple[_Metres, ...], AfterValidator(_check_position)]
_ROBOT_TOPIC: Final = re.compile(r"(.+)/v\d{1,3}/[^/]+/[^/]+/(?:connection|factsheet|state|visualization)")
_Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=100)]


class Vda5050Settings(ConventionSettings):
    """The table of this convention.

    Attributes:
        interfaces: The first levels of topics, one for each fleet.
        nodes: Where robots may be sent, by the id of the node: x and y in metres on the robot's map, and the heading in
            radians if it matters; empty for a robot that knows the node by its id.
        charger: The node where robots charge; empty for robots that charge where they stand.
    """

    interfaces: tuple[TopicPrefix, ...] = ("uagv", "vda5050")
    nodes: Annotated[Mapping[_Name, _Position], Field(max_length=1000)] = Field(default_factory=dict)
    charger: str = ""

    @model_validator(mode="after")
    def _check_charger(self) -> Self:
        if self.charger and self.charger not in self.nodes:
            raise ValueError(f"charger {self.charger!r} is none of nodes: {', '.join(self.nodes) or 'none'}")
        return self


class Vda5050(LazyConvention[Vda5050Settings, "Vda5050Reader"]):
    """Robots, by their first connection, state or factsheet."""

    Settings: ClassVar[type[BaseModel]] = Vda5050Settings
    name: ClassVar[str] = "vda5050"

    def filters(self) -> tuple[str, ...]:
        """Return the filters of the messages of robots."""
        topics = ("connection", "factsheet", "state")
        return tuple(f"{interface}/+/+/+/{topic}" for interface in self.settings.interfaces for topic in topics)

    def hint(self, topic: str) -> str:
        """Return how the robot that publishes on *topic* is found, if it does so below other first levels."""
        found = _ROBOT_TOPIC.fullmatch(topic)
        if found is None or found[1] in self.settings.interfaces:
            return ""
        known = ", ".join(f'"{interface}"' for interface in (*self.settings.interfaces, found[1][:100]))
        return f"a robot of VDA 5050 may publish below {found[1][:100]}; to find it: vda5050.interfaces = [{known}]"

    def load_reader(self) -> Vda5050Reader:
        """Return a reader of the messages of robots."""
        from homebot.integrations.vda5050.formats.reader import Vda5050Reader  # noqa: PLC0415 - see LazyConvention

        return Vda5050Reader(self.settings.nodes, self.settings.charger)
