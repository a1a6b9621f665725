"""What every application is: a node that acts on the devices of the house."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict

from homebot.devices import Devices
from homebot.graph import Node

__all__ = ["App", "NoSettings"]


class NoSettings(BaseModel):
    """The settings of an app that has none."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class App(ABC):
    """The base of applications; the plug-in group is ``homebot.apps``.

    Write :meth:`run`, and give :attr:`Settings` a pydantic model when the app can be configured.

    Args:
        node: The node it is: ``/<name>``.
        settings: Its table ``[apps.NAME]``, checked; an instance of :attr:`Settings`.

    Attributes:
        Settings: The model of its table.
        node: That node, for topics, services, timers and parameters of its own.
        devices: The devices of the house.
    """

    Settings: ClassVar[type[BaseModel]] = NoSettings

    def __init__(self, node: Node, settings: BaseModel) -> None:  # noqa: ARG002  # what every app is given
        self.node = node
        self.devices = Devices(node)

    @abstractmethod
    async def run(self) -> None:
        """Do what the app is for, until cancelled; returning ends the app in good order."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Run the app; the runtime calls this."""
        task_status.started()
        await self.run()
