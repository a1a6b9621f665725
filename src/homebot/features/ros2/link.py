"""The link between the graph and ROS 2 nodes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import TYPE_CHECKING

import anyio
from anyio.abc import TaskStatus

from homebot.bridges.zenoh.bridge_tokens import ALL_BRIDGE_TOKENS
from homebot.bridges.zenoh.entities import OwnEntities
from homebot.bridges.zenoh.logins import login_notes
from homebot.bridges.zenoh.tokens import ALL_TOKENS
from homebot.features.ros2.exports import Exports
from homebot.features.ros2.health import LinkHealth
from homebot.features.ros2.imports import Imports
from homebot.features.ros2.robots import RobotsOnWire
from homebot.graph import Node

if TYPE_CHECKING:
    from homebot.bridges.zenoh.session import ZenohSession
    from homebot.messages.interfaces.settings import RosSettings
    from homebot.runtime.session_keeper import OpenSession


async def serve(opened: OpenSession, *, task_status: TaskStatus[None]) -> None:
    """Link robots to the graph of the house, with the rights of their tokens, until cancelled.

    Raises:
        UsageError: A robot has no token.
    """
    plan, imports = opened.plan, opened.settings.imports
    revoked = () if plan.link is None else plan.link.imports.keys() - imports.keys()
    robots = RobotsOnWire.of(imports, plan.door, plan.robot_owners(), opened.graph.clock.now, sorted(revoked))
    async with Node(opened.graph, "ros2") as node:
        notes = () if plan.link is None else tuple(login_notes(plan.link, plan.door))
        await serve_link(node, opened.session, opened.settings, robots, notes, task_status=task_status)


async def serve_link(
    node: Node,
    session: ZenohSession,
    settings: RosSettings,
    robots: RobotsOnWire,
    notes: tuple[str, ...] = (),
    *,
    task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED,
) -> None:
    """Export entities to robots, and import theirs to the graph of *node*, until cancelled."""
    own = OwnEntities(node, session, settings.domain)
    health = LinkHealth(node)
    imports = Imports(node, own, robots, health)
    exports = Exports(node, own, settings.export, robots, imports.caller_of, imports.has_node, health)

    def problems() -> Iterator[str]:
        yield from robots.problems()
        yield from imports.problems
        yield from exports.problems(imports.tokens)
        if settings.connect and session.is_alone:
            yield f"no router at {', '.join(settings.connect)} lets it in: does it run, and does it know the login?"

    health.serve(lambda: session.lost, problems, notes)
    with closing(imports), node.graph.watch() as changes:
        exports.refresh_all()
        every = (ALL_TOKENS.format(domain=settings.domain), ALL_BRIDGE_TOKENS)
        _watching = [session.watch_tokens(tokens, imports.on_token) for tokens in every]
        task_status.started()
        lost = 0
        async for change in changes:
            exports.refresh(change.entity.kind, change.entity.name)
            if changes.lost > lost:
                lost = changes.lost
                exports.refresh_all()
