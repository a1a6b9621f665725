"""An app that gives random commands at random times; all that it does is in its settings."""

import anyio
from pydantic import BaseModel, ConfigDict

from homebot.apps import App
from homebot.devices.handles import Handle
from homebot.errors import HomebotError
from homebot.graph import Node

RANDOM_APP = f"{__name__}:RandomApp"


class Order(BaseModel):
    """One command.

    Attributes:
        at: Seconds after the start.
        device: The name of the device.
        capability: What is set.
        value: To what.
        text: The same as a raw text; empty for a command of a handle.
    """

    model_config = ConfigDict(frozen=True)

    at: float
    device: str
    capability: str
    value: bool | float | str
    text: str = ""


class RandomAppSettings(BaseModel):
    """The commands of one app."""

    orders: tuple[Order, ...] = ()


class RandomApp(App):
    """Gives its commands, each at its time, and waits for none."""

    Settings = RandomAppSettings

    def __init__(self, node: Node, settings: RandomAppSettings) -> None:
        super().__init__(node, settings)
        self._orders = sorted(settings.orders, key=lambda one: one.at)

    async def run(self) -> None:
        """Give them."""
        begin = anyio.current_time()
        async with anyio.create_task_group() as tasks:
            for order in self._orders:
                await anyio.sleep_until(begin + order.at)
                tasks.start_soon(self._give, order)

    async def _give(self, order: Order) -> None:
        for handle in await self.devices.find(Handle):
            if handle.device.name == order.device and handle.can(order.capability):
                try:
                    await give(self, handle, order)
                except HomebotError:
                    return  # refused, or out of reach: the journal has it


async def give(app: App, handle: Handle, order: Order) -> None:
    """Give one command, by a text or a handle."""
    if order.text:
        await app.devices.tell(handle.device, order.text)
    else:
        await handle.command(order.capability, order.value)
