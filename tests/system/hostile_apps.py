"""Apps that misbehave, each in one way; see test_hostile_apps.py."""

import asyncio
import signal
import sys
import threading
import time
from typing import NoReturn

import anyio
import anyio.lowlevel
from pydantic import BaseModel

from homebot.apps import App
from homebot.graph import Node
from homebot.messages import String, Trigger
from homebot.messages.std_srvs import SuccessResponse, TriggerRequest

PERIOD = 0.5


async def await_a_cancelled_task() -> None:
    task = asyncio.create_task(anyio.sleep_forever())
    await anyio.lowlevel.checkpoint()
    task.cancel()
    await task


class Raiser(App):
    async def run(self) -> None:
        raise ValueError("no such lamp")


class CancelsTask(App):
    async def run(self) -> None:
        await anyio.sleep(PERIOD)
        await await_a_cancelled_task()


class CancelsItself(App):
    async def run(self) -> None:
        await anyio.sleep(PERIOD)
        task = asyncio.current_task()
        assert task is not None
        task.cancel()
        await anyio.sleep(1)


class Exits(App):
    async def run(self) -> None:
        await anyio.sleep(PERIOD)
        sys.exit(3)


class ExitsInTask(App):
    """In a task of its own, which no part of homebot runs."""

    async def run(self) -> None:
        async def leave() -> NoReturn:
            await anyio.sleep(PERIOD)
            sys.exit(4)

        self.task = asyncio.create_task(leave())
        await anyio.sleep_forever()


class RaisesGeneratorExit(App):
    async def run(self) -> None:
        await anyio.sleep(PERIOD)
        raise GeneratorExit


class RaisesAtStart(App):
    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        raise RuntimeError("cannot be made")

    async def run(self) -> None:
        """Never comes to this."""


class ReturnsEarly(App):
    async def run(self) -> None:
        return


class BadHandler(App):
    async def run(self) -> None:
        self.node.create_subscription(String, "/hostile", self.handle)
        publisher = self.node.create_publisher(String, "/hostile")
        while True:
            publisher.publish(String(data="good"))
            publisher.publish(String(data="bad"))
            await anyio.sleep(PERIOD)

    async def handle(self, message: String) -> None:
        if message.data == "bad":
            await await_a_cancelled_task()


class BadTimer(App):
    async def run(self) -> None:
        self.node.create_timer(PERIOD, self.tick)
        await anyio.sleep_forever()

    def tick(self) -> None:
        raise OSError("\x1b]0;owned\x07 the disk of a \x1b[31mstranger\x1b[0m")


class BadService(App):
    async def run(self) -> None:
        self.node.create_service(Trigger, "/bad_service", self.answer)
        await anyio.sleep_forever()

    async def answer(self, _request: TriggerRequest) -> SuccessResponse:
        await await_a_cancelled_task()
        raise AssertionError


class Blocks(App):
    async def run(self) -> None:
        while True:
            await anyio.sleep(3)
            time.sleep(1.6)  # noqa: ASYNC251


class Prints(App):
    """Writes as much as it can."""

    async def run(self) -> None:
        while True:
            print("nobody reads this" * 100)
            for _ in range(20):
                self.node.log.info("noise", message="nobody reads this either" * 40)
            await anyio.sleep(0.001)


class ClingsOn(App):
    """Does not end when it is to."""

    async def run(self) -> None:
        while True:
            try:
                await anyio.sleep_forever()
            except anyio.get_cancelled_exc_class():
                continue


class BlocksInC(App):
    """Does not come back from a call into C, which nothing interrupts: another thread takes the signal."""

    async def run(self) -> None:
        threading.Timer(0.2, lambda: signal.pthread_kill(threading.get_ident(), signal.SIGTERM)).start()
        time.sleep(60)  # noqa: ASYNC251
