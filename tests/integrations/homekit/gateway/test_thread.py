"""Accessories over Thread are paired, read, commanded and heard by CoAP, as aiohomekit does it."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.integrations.homekit.gateway.thread_accessory import BRIGHTNESS, ON, PIN, ThreadLamp
from tests.patience import PATIENCE

from homebot.errors import LinkError, PeerError, RefusedError, WrongCodeError
from homebot.integrations.homekit.formats.accessory import parse_accessories
from homebot.integrations.homekit.gateway.aiohomekit_port import AiohomekitPort
from homebot.integrations.homekit.gateway.port import HomekitLink, HomekitValues, Pairing

IDS = ((1, ON), (1, BRIGHTNESS))


async def pair(lamp: ThreadLamp) -> Pairing:
    """Pair with the right code: HAP-python 5.0 loses leading zeros of SRP, and refuses some."""
    for _ in range(5):
        try:
            return await AiohomekitPort().pair(lamp.found, PIN)
        except WrongCodeError:
            pass
    raise AssertionError("it was refused again and again")


class Heard:
    """The values that were heard."""

    def __init__(self) -> None:
        self.values: list[HomekitValues] = []
        self._changed = anyio.Event()

    def put(self, values: HomekitValues) -> None:
        self.values.append(values)
        self._changed.set()

    async def wait(self) -> HomekitValues:
        with anyio.fail_after(PATIENCE):
            await self._changed.wait()
        return self.values[-1]


@asynccontextmanager
async def connected(lamp: ThreadLamp, keys: Pairing, heard: Heard | None = None) -> AsyncIterator[HomekitLink]:
    async with AiohomekitPort().connected(lamp.found, keys, (heard or Heard()).put) as link:
        await link.list_accessories()
        yield link


async def test_a_lamp_is_paired_read_commanded_heard_and_unpaired() -> None:
    lamp, heard = ThreadLamp(), Heard()
    async with lamp.running():
        keys = await pair(lamp)
        async with connected(lamp, keys, heard) as link:
            (accessory,) = parse_accessories(await link.list_accessories()).values()
            assert (accessory.information.text("23"), accessory.sleeps) == ("Hall", False)
            assert accessory.services[8].characteristics["8"].bounds == (0.0, 100.0)
            await link.subscribe(IDS)
            assert await link.read(IDS) == {(1, ON): {"value": False}, (1, BRIGHTNESS): {"value": 50}}
            assert await link.write({(1, ON): True, (1, BRIGHTNESS): 40}, is_timed=False) == {}
            assert lamp.written == [(ON, b"\1"), (BRIGHTNESS, b"\x28\0\0\0")]
            assert [one for one in heard.values if one] == []  # a written value is no report
            await lamp.report(ON, b"\1")
            assert await heard.wait() == {(1, ON): {"value": True}}
            await link.unpair()
        assert not lamp.state.paired
        with pytest.raises(RefusedError, match="does not know homebot any more"):
            async with connected(lamp, keys):
                pytest.fail("it connected")


async def test_a_wrong_code_and_the_lamp_of_another_controller_are_refused() -> None:
    lamp = ThreadLamp()
    async with lamp.running():
        with pytest.raises(WrongCodeError, match="the code is wrong; if you are sure of it, try once more"):
            await AiohomekitPort().pair(lamp.found, "111-11-111")
        await pair(lamp)
        with pytest.raises(PeerError, match="another controller"):
            await AiohomekitPort().pair(lamp.found, PIN)


async def test_a_lamp_that_refuses_says_so_with_its_status() -> None:
    lamp = ThreadLamp()
    async with lamp.running(), connected(lamp, await pair(lamp)) as link:
        lamp.refuses = True
        assert await link.write({(1, ON): True}, is_timed=False) == {(1, ON): -6}


async def test_a_lamp_that_restarted_is_lost_and_connected_anew() -> None:
    lamp = ThreadLamp()
    async with lamp.running():
        keys = await pair(lamp)
        async with connected(lamp, keys) as link:
            lamp.session = None
            with pytest.raises(LinkError):
                await link.write({(1, ON): True}, is_timed=False)
            assert link.lost.is_set()
        async with connected(lamp, keys) as link:
            await link.write({(1, ON): True}, is_timed=False)
    assert lamp.written == [(ON, b"\1")]


async def test_a_write_that_expires_without_an_answer_ends_the_session() -> None:
    lamp = ThreadLamp()
    async with lamp.running(), connected(lamp, await pair(lamp)) as link:
        lamp.answers = anyio.Event()
        with anyio.move_on_after(0.2):
            await link.write({(1, BRIGHTNESS): 70}, is_timed=False)
        assert link.lost.is_set()
        lamp.answers.set()
        with pytest.raises(LinkError):
            await link.read(IDS)
