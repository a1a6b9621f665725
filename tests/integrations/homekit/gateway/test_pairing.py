"""Accessories are paired by their codes; keys are kept, codes are not, and doctor names the next step."""

import json
import logging
import stat
from pathlib import Path

import anyio
import pytest
from tests.gateways.watched_gateway import reading, receive
from tests.integrations.homekit.gateway.fake_accessories import CODE, FakeServer, accessory, lamp_service
from tests.integrations.homekit.gateway.house import house, paired

pytestmark = pytest.mark.virtual_time

KEY = "AA:BB:CC:DD:EE:01"


def lamp() -> FakeServer:
    return FakeServer(KEY, "Hall lamp", accessory(1, "Hall lamp", lamp_service()))


async def test_an_accessory_that_waits_says_the_command_and_is_paired_by_it(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    server, pairings = lamp(), tmp_path / "pairings.json"
    async with house(server, pairings=pairings) as home:
        health = await home.health()
        (note,) = health.notes
        assert health.troubles == ()
        assert "`homebot pair 'Hall lamp' CODE`" in note
        wrong = await home.pair(server, "111-11-111")
        assert (wrong.problem, "111" in wrong.message) == ("refused", False)
        right = await home.pair(server, CODE)
        assert (right.success, right.name) == (True, "Hall lamp")
        await reading(home.reports(), "on_off", False)
        health = await home.health()
        assert (health.troubles, health.notes) == ((), ())
        assert "paired with homebot already" in (await home.pair(server, CODE)).message
        assert stat.S_IMODE(pairings.stat().st_mode) == 0o600
        assert CODE not in pairings.read_text() + repr(home.gateway.__dict__)
    assert CODE not in caplog.text
    async with house(server, pairings=pairings) as home:
        await reading(home.reports(), "on_off", False)


@pytest.mark.parametrize(("code", "reason"), [("", "by the code"), ("1234", "8 digits"), ("X-HM://1", "9 digits")])
async def test_a_code_that_is_none_is_refused_before_it_is_sent(code: str, reason: str) -> None:
    server = lamp()
    async with house(server) as home:
        answer = await home.pair(server, code)
    assert (answer.problem, server.knows_homebot) == ("refused", False)
    assert reason in answer.message


async def test_an_accessory_that_is_paired_with_another_controller_says_so() -> None:
    server = lamp()
    async with house(server) as home:
        home.mdns.announce(server, txt_sf="0")
        await anyio.wait_all_tasks_blocked()
        (note,) = (await home.health()).notes
        assert "paired with another controller" in note
        answer = await home.pair(server, CODE)
        assert (answer.problem, server.knows_homebot) == ("refused", False)
        assert "another controller" in answer.message


async def test_an_accessory_that_does_not_know_homebot_any_more_needs_help() -> None:
    server = lamp()
    async with paired(server) as (home, reports):
        server.knows_homebot = False
        server.drop()
        await reading(reports, "reachable", False)
        await anyio.sleep(5)
        (trouble,) = (await home.health()).troubles
        assert "it does not know homebot any more" in trouble


async def test_unpairing_removes_the_key_there_and_here(tmp_path: Path) -> None:
    server, pairings = lamp(), tmp_path / "pairings.json"
    async with paired(server, pairings=pairings) as (home, _):
        sightings = home.sightings()
        assert (await home.unpair_from(KEY)).success
        assert (server.knows_homebot, json.loads(pairings.read_text())) == (False, {})
        bare = await receive(sightings, lambda one: not one.parts and one.kind != "removed")
        assert bare.key == KEY
        assert (await home.unpair_from(KEY)).problem == "refused"


async def test_the_key_of_an_accessory_that_is_away_is_deleted(tmp_path: Path) -> None:
    server, pairings = lamp(), tmp_path / "pairings.json"
    async with paired(server, pairings=pairings) as (home, reports):
        server.is_there = False
        server.drop()
        await reading(reports, "reachable", False)
        assert (await home.unpair_from(KEY)).success
        assert json.loads(pairings.read_text()) == {}


async def test_one_that_is_not_announced_any_more_is_forgotten_unless_it_is_paired() -> None:
    server = lamp()
    async with house(server) as home:
        sightings = home.sightings()
        home.mdns.announce(server, is_removed=True)
        assert (await receive(sightings, lambda one: one.kind == "removed")).key == KEY
        home.mdns.announce(server)
        await anyio.wait_all_tasks_blocked()
        await home.pair(server, CODE)
        await reading(home.reports(), "on_off", False)
        home.mdns.announce(server, is_removed=True)
        await anyio.wait_all_tasks_blocked()
        assert home.gateway.devices.keys == (KEY,)
