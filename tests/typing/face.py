"""What ``from homebot import …`` promises to a type checker; read by mypy, never run.

An expected error is marked ``type: ignore``, and mypy complains about each mark that is not needed.
"""

from typing import assert_type

import homebot
from homebot import App, Device, DeviceChange, Light, Node, RefusedError, qos_profile_latched, run
from homebot.apps import App as AppOfItsPackage
from homebot.apps import AppSettings
from homebot.messages import String


class Evening(App):
    async def run(self) -> None:
        async for change in self.devices.follow("lights"):
            assert_type(change, DeviceChange)
            assert_type(change.device, Device)
        for lamp in await self.devices.find(Light, on=True):
            assert_type(lamp, Light)
            try:
                await lamp.turn_on(level=40)
            except RefusedError as exc:
                assert_type(exc.reason, str)


class Morning(App[AppSettings]):
    async def run(self) -> None:
        assert_type(self.settings, AppSettings)


def start() -> None:
    run(Morning)
    assert_type(run(Evening), int)
    run(Evening, "light_service", mqtt="mqtt://127.0.0.1", act=True)
    run(Evening, mqqt="mqtt://127.0.0.1")  # type: ignore[call-arg]  # no such option
    run(Light)  # type: ignore[arg-type]  # no app
    assert_type(homebot.run(Evening, seconds=1.5), int)
    _ = homebot.Lihgt  # type: ignore[attr-defined]  # no such name


def same(app: AppOfItsPackage, node: Node) -> App:
    node.create_publisher(String, "t", qos_profile_latched)
    return app


class Later(App):
    async def run(self) -> None:
        self.after("5m", self.switch, args=("hall", True), name="off", durable=True)
        self.after("5m", self.switch)  # type: ignore[arg-type]  # the arguments are missing
        self.after("5m", self.switch, args=("hall", "on"))  # type: ignore[arg-type]  # another type

    def switch(self, name: str, on: bool) -> None: ...  # noqa: FBT001 - a handler's arguments are positional
