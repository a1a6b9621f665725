"""The other machines of the house on the link of ``[ros]``: their gateways here, and those of this machine there."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, final

from pydantic import SecretStr

from homebot.devices.names import MACHINE_NODE
from homebot.graph import Graph, Node
from homebot.support.file_access import read_secret

if TYPE_CHECKING:
    from homebot.bridges.ros2.session import ZenohSession
    from homebot.messages.interfaces.settings import RosSettings

__all__ = ["MachinesOnWire"]


@final
class MachinesOnWire:
    """The session for gateways of other machines, and the exports of this one if it is another machine.

    Args:
        home: The name of the home.
        exported: The gateways of this machine, those of other machines left out.

    Attributes:
        session: The session of the link; None while there is none.
    """

    def __init__(self, home: str = "", exported: tuple[str, ...] = ()) -> None:
        self._home, self._exported = home, exported
        self.session: ZenohSession | None = None

    @asynccontextmanager
    async def linked(self, graph: Graph, settings: RosSettings, session: ZenohSession) -> AsyncIterator[None]:
        """Use *session* inside the block, in which its calls are made by another task.

        Raises:
            UsageError: The secret cannot be read.
        """
        self.session = session
        try:
            async with AsyncExitStack() as stack:
                if settings.machine and settings.password_file is not None:
                    from homebot.bridges.machines.exports import serve_gateways  # noqa: PLC0415 - few are another one
                    from homebot.bridges.machines.wire import MachineWire  # noqa: PLC0415 - as above

                    node = await stack.enter_async_context(Node(graph, MACHINE_NODE.removeprefix("/")))
                    wire = MachineWire(node, session, SecretStr(read_secret(settings.password_file)))
                    node.create_task(partial(serve_gateways, node, wire, self._home, settings.machine, self._exported))
                yield
        finally:
            self.session = None
