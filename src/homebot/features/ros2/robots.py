"""The robots on the other side: their nodes, and their rights. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from math import inf
from types import MappingProxyType
from typing import TYPE_CHECKING, final

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.zenoh.logins import token_of
from homebot.errors import PeerError, UsageError
from homebot.support.name_patterns import fits_any
from homebot.words.rights import read_scope

if TYPE_CHECKING:
    from homebot.bridges.rosbridge import RosbridgeSettings
    from homebot.devices.robot_owners import RobotOwners


@final
class RobotsOnWire:
    """The robots whose topics and services are imported.

    Args:
        imports: Patterns of names by robot.
        accesses: The access of each robot: that of its token.
        ends: When the token of each ends, in seconds since 1970.
        now: Returns the time.
        revoked: Robots that would be imported if they still had a token.
    """

    def __init__(
        self,
        imports: Mapping[str, Iterable[str]],
        accesses: Mapping[str, ClientAccess],
        ends: Mapping[str, float] = MappingProxyType({}),
        now: Callable[[], float] = lambda: -inf,
        revoked: Iterable[str] = (),
    ) -> None:
        self._imports, self._accesses, self._ends, self._now = imports, accesses, ends, now
        self._revoked = tuple(revoked)

    @classmethod
    def of(
        cls,
        imports: Mapping[str, Iterable[str]],
        door: RosbridgeSettings,
        owners: RobotOwners,
        now: Callable[[], float] = lambda: -inf,
        revoked: Iterable[str] = (),
    ) -> RobotsOnWire:
        """Return the robots with the rights of their tokens in *door*, until *now* passes their ends.

        Raises:
            UsageError: A robot has no token.
        """
        accesses, ends = {}, {}
        for robot in imports:
            name = token_of(robot, door)
            if name is None:
                raise UsageError(f"[ros] import: no token has the right 'robot: {robot}'; {_make_one(robot)}")
            token = door.tokens[name]
            accesses[robot], ends[robot] = ClientAccess(name, read_scope(token.scope), owners), token.until
        return cls(imports, accesses, ends, now, revoked)

    def source_of(self, name: str) -> ClientAccess | None:
        """Return the access of the robot from which the topic or service *name* comes.

        None if it is not imported, or if the token of the robot has ended.
        """
        robot = next((robot for robot, patterns in self._imports.items() if fits_any(name, patterns)), None)
        return None if robot is None or self._has_ended(robot) else self._accesses[robot]

    def problems(self) -> Iterator[str]:
        """Yield from which robots nothing is taken, and why."""
        for robot, access in self._accesses.items():
            if self._has_ended(robot):
                yield f"nothing is taken from {robot}: the token {access.name} has ended; {_make_one(robot)}"
        for robot in self._revoked:
            yield f"nothing is taken from {robot}: no token has the right 'robot: {robot}' now; {_make_one(robot)}"

    @property
    def are_several(self) -> bool:
        """True if the rights of a caller depend on its node."""
        return len(self._accesses) > 1

    def caller(self, node: str) -> ClientAccess:
        """Return the access of the robot to which *node* belongs: the only one, or that of its namespace.

        Raises:
            PeerError: It belongs to none, or the token of its robot has ended.
        """
        robot = node.split("/", 2)[1] if node else ""
        if self._accesses and not self.are_several:
            robot = next(iter(self._accesses))
        if robot not in self._accesses:
            known = ", ".join(f"/{access}/…" for access in self._accesses) or "none: name it in import of [ros]"
            raise PeerError(f"the node {node or 'without a token'} belongs to no robot; robots have {known}")
        if self._has_ended(robot):
            raise PeerError(f"the token {self._accesses[robot].name} has ended; its table says until when")
        return self._accesses[robot]

    def _has_ended(self, robot: str) -> bool:
        return self._now() >= self._ends.get(robot, inf)


def _make_one(robot: str) -> str:
    return f"make one: homebot token new {robot} --scope read --scope 'robot: {robot}'"
