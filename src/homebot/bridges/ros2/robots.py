"""The robots on the other side: what comes from which, and with which rights. Pure."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, final

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.devices.client_rights import read_scope
from homebot.errors import PeerError, UsageError

if TYPE_CHECKING:
    from homebot.bridges.rosbridge import DoorSettings
    from homebot.devices.robot_owners import RobotOwners

__all__ = ["RobotsOnWire", "fits_any"]


@final
class RobotsOnWire:
    """The robots whose topics and services are imported.

    Args:
        imports: Patterns of names by robot.
        accesses: The access of each robot: that of its token.
    """

    def __init__(self, imports: Mapping[str, Iterable[str]], accesses: Mapping[str, ClientAccess]) -> None:
        self._imports, self._accesses = imports, accesses

    @classmethod
    def of(cls, imports: Mapping[str, Iterable[str]], door: DoorSettings, owners: RobotOwners) -> RobotsOnWire:
        """Return the robots with the rights of their tokens in *door*.

        Raises:
            UsageError: A robot has no token.
        """
        found = {}
        for robot in imports:
            rights = {name: read_scope(one.scope) for name, one in door.tokens.items()}
            name = next((name for name, one in rights.items() if robot in one.robots), None)
            if name is None:
                raise UsageError(
                    f"[ros] import: no token has the right 'robot: {robot}'; make one: "
                    f"homebot token new {robot} --scope read --scope 'robot: {robot}'"
                )
            found[robot] = ClientAccess(name, rights[name], owners)
        return cls(imports, found)

    def source_of(self, name: str) -> ClientAccess | None:
        """Return the access of the robot from which the topic or service *name* comes; None if it is not imported."""
        robot = next((robot for robot, patterns in self._imports.items() if fits_any(name, patterns)), None)
        return None if robot is None else self._accesses[robot]

    def caller(self, node: str) -> ClientAccess:
        """Return the access of the robot to which *node* belongs: the only one, or that of its namespace.

        Raises:
            PeerError: It belongs to none.
        """
        if len(self._accesses) == 1:
            return next(iter(self._accesses.values()))
        robot = node.split("/", 2)[1] if node else ""
        if robot not in self._accesses:
            known = ", ".join(f"/{one}/…" for one in self._accesses) or "none: name it in import of [ros]"
            raise PeerError(f"the node {node or 'without a token'} belongs to no robot; robots have {known}")
        return self._accesses[robot]


def fits_any(name: str, patterns: Iterable[str]) -> bool:
    """Return whether the full name *name* fits one of *patterns*."""
    return any(_compiled(pattern).fullmatch(name) for pattern in patterns)


@lru_cache(maxsize=256)
def _compiled(pattern: str) -> re.Pattern[str]:
    parts = (".*" if part == "**" else part.replace("*", "[^/]*") for part in pattern.split("/"))
    return re.compile("/".join(parts))
