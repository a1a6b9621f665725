"""The base class of apps: a node that acts on the devices of the house."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict

from homebot.devices import Devices
from homebot.graph import Node

__all__ = ["App", "AppSettings", "NoSettings"]


class AppSettings(BaseModel):
    """The base class of tables of apps: read once, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class NoSettings(AppSettings):
    """The empty table of an app without settings."""


class App(ABC):
    """The base class of apps; the entry-point group is ``homebot.apps``.

    Override :meth:`run`. For settings, assign a pydantic model to ``Settings``.

    Args:
        node: The node of the app, ``/<name>``.
        settings: The table ``[apps.NAME]`` of the configuration, validated: an instance of ``Settings``.

    Attributes:
        Settings: The model of the app's table; by default a table with keys is an error.
        node: The node of the app, for its topics, services, timers, parameters and log.
        devices: The devices of the house.
    """

    Settings: ClassVar[type[BaseModel]] = NoSettings

    def __init__(self, node: Node, settings: BaseModel) -> None:  # noqa: ARG002  # for subclasses
        self.node = node
        self.devices = Devices(node)

    @abstractmethod
    async def run(self) -> None:
        """Run until cancelled; returning ends the app in good order.

        An exception is logged and the app started again, half a second later at first; after five crashes within a
        minute it is given up.
        """

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Run the app; the runtime calls this."""
        task_status.started()
        await self.run()
