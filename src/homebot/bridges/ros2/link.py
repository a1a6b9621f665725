"""The link between the graph and ROS 2 nodes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import TYPE_CHECKING

import anyio
from anyio.abc import TaskStatus

from homebot.bridges.ros2.entities import OwnEntities
from homebot.bridges.ros2.exports import Exports
from homebot.bridges.ros2.health import LinkHealth
from homebot.bridges.ros2.imports import Imports
from homebot.bridges.ros2.tokens import ALL_TOKENS
from homebot.graph import Node

if TYPE_CHECKING:
    from homebot.bridges.ros2.robots import RobotsOnWire
    from homebot.bridges.ros2.session import ZenohSession
    from homebot.messages.interfaces.settings import RosSettings


async def serve_link(
    node: Node,
    session: ZenohSession,
    settings: RosSettings,
    robots: RobotsOnWire,
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

    health.serve(lambda: session.lost, problems)
    with closing(imports), node.graph.watch() as changes:
        exports.refresh_all()
        _watching = session.watch_tokens(ALL_TOKENS.format(domain=settings.domain), imports.on_token)
        task_status.started()
        lost = 0
        async for change in changes:
            exports.refresh(change.entity.kind, change.entity.name)
            if changes.lost > lost:
                lost = changes.lost
                exports.refresh_all()
