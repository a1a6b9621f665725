"""The part of a machine with gateways only, while its session with the house is open."""

from __future__ import annotations

from typing import TYPE_CHECKING

from anyio.abc import TaskStatus
from pydantic import SecretStr

from homebot.devices.names import MACHINE_NODE
from homebot.graph import Node
from homebot.support.file_access import read_secret

if TYPE_CHECKING:
    from homebot.runtime.session_keeper import OpenSession


async def serve(opened: OpenSession, *, task_status: TaskStatus[None]) -> None:
    """Let the homebot of the house have the gateways of this machine, if it is another one, until cancelled."""
    plan, settings = opened.plan, opened.settings
    if not settings.machine or settings.password_file is None:
        task_status.started()
        return
    from homebot.features.machine.exports import serve_gateways  # noqa: PLC0415 - few are another one
    from homebot.features.machine.wire import MachineWire  # noqa: PLC0415 - as above

    async with Node(opened.graph, MACHINE_NODE.removeprefix("/")) as node:
        wire = MachineWire(node, opened.session, SecretStr(read_secret(settings.password_file)))
        names = plan.home, settings.machine, plan.own_gateways
        await serve_gateways(node, wire, *names, task_status=task_status)
