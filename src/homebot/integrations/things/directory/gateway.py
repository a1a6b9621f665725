"""The gateway to a directory of things: the code without libraries; the rest is loaded when it serves."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, ClassVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, PeerError
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext
from homebot.gateways.password_settings import read_logins
from homebot.graph import Node
from homebot.integrations.things.directory.settings import ThingDirectorySettings
from homebot.plugins import check_extra
from homebot.support.backoff import DEVICE_BACKOFF, DEVICE_REFUSED_BACKOFF, BackoffCounter

if TYPE_CHECKING:
    from homebot.integrations.things.directory.session import DirectorySession


class ThingDirectoryGateway(Gateway):
    """A gateway to the things that a W3C Thing Description Directory lists.

    The directory lists the things; each is connected to separately, at the addresses in its description. While the
    directory is away, known things stay in use.
    """

    Settings: ClassVar[type[BaseModel]] = ThingDirectorySettings

    def __init__(self, node: Node, settings: ThingDirectorySettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._settings = settings
        self._retries = BackoffCounter(node.graph.clock, self.random)
        self._session: DirectorySession | None = None
        self.devices = PublishedDevices(
            self, self._perform, settings, max_devices=settings.max_devices, find_problems=self._problems
        )

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Check aiohttp and the passwords."""
        check_extra('the gateway "thing_directory"', "mdns", "aiohttp")
        if isinstance(settings, ThingDirectorySettings):
            read_logins(settings.credentials)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Follow the directory until cancelled; ready after the first attempt to read its list."""
        from homebot.integrations.things.directory.session import DirectorySession  # noqa: PLC0415 - loads aiohttp

        def has_listed() -> None:
            self._retries.succeed()
            self.devices.problems = ()
            self.publish_state("active")
            self.mark_ready(task_status)

        async with anyio.create_task_group() as tasks:
            session = DirectorySession(self._settings, self.devices, tasks, has_listed)
            self._session = session
            while True:
                backoff, problem = DEVICE_BACKOFF, ""
                try:
                    await session.follow()
                except LinkError as exc:
                    problem = str(exc)
                except PeerError as exc:
                    backoff, problem = DEVICE_REFUSED_BACKOFF, str(exc)
                self.devices.problems = (problem,)
                self.publish_state("unavailable", problem)
                self.mark_ready(task_status)
                await anyio.sleep(self._retries.fail(backoff))

    def _problems(self) -> Iterable[str]:
        return () if self._session is None else self._session.problems()

    async def _perform(self, command: Command) -> None:
        if self._session is None:
            raise LinkError("the directory was not read yet")
        await self._session.perform(command)
