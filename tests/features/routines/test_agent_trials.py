"""The trials that agents ask for."""

from unittest.mock import create_autospec

import anyio
import pytest
from anyio.abc import SocketAttribute
from tests.patience import PATIENCE

pytest.importorskip("mcp")

from homebot.bridges.home_api.agent_server import HouseApi, RosbridgeAddress
from homebot.features.routines.agent_tools import Trials

pytestmark = pytest.mark.slow

TEXT = 'name = "Hall"\nwhen = ["hall motion occupied"]\ndo = ["hall lamp on"]\n'


async def test_a_trial_that_goes_on_ends_with_homebot() -> None:
    async with await anyio.create_tcp_listener(local_host="127.0.0.1") as silent:  # it takes connections, and is silent
        port = silent.listeners[0].extra(SocketAttribute.local_port)  # noqa: S610 - no Django
        api = create_autospec(HouseApi, instance=True)
        api.server, api.is_of_house = RosbridgeAddress("127.0.0.1", port, "token", has_tls=False), True
        trials = Trials(0.05)
        assert await trials.lines(api, TEXT, 1.0) == ["a trial goes on: ask the same again later"]
        trials.close()
        with anyio.fail_after(PATIENCE):
            while (lines := await trials.lines(api, TEXT, 1.0)) == ["a trial goes on: ask the same again later"]:
                pass
    assert lines == ["no trial: "]


async def test_a_trial_that_takes_long_says_that_it_goes_on() -> None:
    api = create_autospec(HouseApi, instance=True)
    api.server, api.is_of_house = RosbridgeAddress("127.0.0.1", 1, "token", has_tls=False), True
    trials = Trials(0.05)
    first = lines = await trials.lines(api, TEXT, 1.0)
    assert first == ["a trial goes on: ask the same again later"]
    with anyio.fail_after(PATIENCE):
        while lines == first:
            lines = await trials.lines(api, TEXT, 1.0)
    assert lines == ["no trial: homebot: no homebot is running on 127.0.0.1:1; start one with `homebot run`\n"]
