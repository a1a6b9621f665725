"""Accessories report and obey; bridges, buttons, silence, restarts and writes that come too late."""

from pathlib import Path

import anyio
import pytest
from tests.gateways.watched_gateway import reading, receive
from tests.integrations.homekit.gateway.fake_accessories import (
    CODE,
    FakeServer,
    accessory,
    characteristic,
    lamp_service,
    service,
)
from tests.integrations.homekit.gateway.house import house, paired

from homebot.integrations.homekit.gateway.accessory_runner import MAX_EVENTS
from homebot.integrations.homekit.gateway.port import HomekitValues

pytestmark = pytest.mark.virtual_time

KEY = "AA:BB:CC:DD:EE:01"
ON = (1, 9)


def lamp() -> FakeServer:
    return FakeServer(KEY, "Hall", accessory(1, "Hall", lamp_service(), serial="SN-4711"))


def lock_service() -> dict[str, object]:
    state = characteristic(21, "1D", 0, ["pr", "ev"])
    return service(20, "45", state, characteristic(22, "1E", 0, ["pr", "pw", "ev", "tw"], maxValue=1, minValue=0))


def bridge() -> FakeServer:
    button = service(30, "89", characteristic(31, "73", None, ["pr", "ev"], **{"valid-values": [0, 2]}))
    return FakeServer(
        KEY,
        "Bridge",
        accessory(1, "Bridge"),
        accessory(2, "Lamp", lamp_service(), serial="SN-4711"),
        accessory(3, "Back door", lock_service(), serial="SN-same1"),
        accessory(4, "Button", button, serial="SN-same1"),
    )


async def test_a_paired_accessory_is_described_with_its_facts_and_reports() -> None:
    server = lamp()
    async with house(server) as home:
        assert (await home.pair(server, CODE)).success
        sightings, reports = home.sightings(), home.reports()
        sighting = await receive(sightings, lambda one: one.parts)
        assert (sighting.key, sighting.name, sighting.authenticated) == (KEY, "Hall", True)
        assert {"manufacturer", "model", "sw_version"} <= {one.key for one in sighting.metadata}
        assert sighting.identifiers == (f"id:homekit {KEY} pairing", "id:SN-4711")
        await reading(reports, "on_off", False)
        server.report(*ON, True)
        await reading(reports, "on_off", True)


async def test_what_was_written_is_read_again_because_no_event_comes() -> None:
    server = lamp()
    async with paired(server) as (home, reports):
        assert (await home.command(KEY, "8", "level", 40.0)).success
        assert server.written == [((1, 9), 1), ((1, 10), 40)]
        await reading(reports, "on_off", True)
        await reading(reports, "level", 40.0)


async def test_an_accessory_that_can_identify_itself_does_and_is_what_it_was() -> None:
    identify = service(1, "3E", characteristic(2, "14", None, ["pw"], format="bool"))
    server = FakeServer(KEY, "Hall", {"aid": 1, "services": [identify, lamp_service()]})
    async with house(server) as home:
        sightings = home.sightings()
        await home.pair(server, CODE)
        hall = await receive(sightings, lambda one: one.parts)
        assert [(one.id, one.service_type, one.category) for one in hall.parts] == [
            ("8", "light", ""),
            ("1", "x_setting", "config"),
        ]
        assert (await home.command(KEY, "1", "locate", True)).success
        assert server.written == [((1, 2), True)]
        await anyio.sleep(60.0)
        assert server.attempts == 1  # what cannot be read is not read


@pytest.mark.parametrize(("serial", "known"), [("00000001", ()), ("00471101", ("id:00471101",))])
async def test_a_serial_number_of_hardly_more_than_zeros_is_shared(serial: str, known: tuple[str, ...]) -> None:
    """HomeSpan's bridge for Daikin air conditioners has 00000001, each copy of it."""
    server = FakeServer(KEY, "Hall", accessory(1, "Hall", lamp_service(), serial=serial))
    async with house(server) as home:
        sightings = home.sightings()
        await home.pair(server, CODE)
        hall = await receive(sightings, lambda one: one.parts)
        assert hall.identifiers == (f"id:homekit {KEY} pairing", *known)


async def test_each_accessory_behind_a_bridge_is_a_device_and_one_that_is_gone_is_removed() -> None:
    server = bridge()
    async with house(server) as home:
        await home.pair(server, CODE)
        sightings = home.sightings()
        door = await receive(sightings, lambda one: one.name == "Back door")
        assert door.key == f"{KEY}.3"
        assert {one.key: one.value for one in door.metadata}["via_device"] == KEY
        assert door.identifiers == (f"id:homekit {KEY.upper()} aid 3", "id:SN-same1")  # as the button: none counts that
        del server.accessories[2]
        home.mdns.announce(server, version="2")
        gone = await receive(sightings, lambda one: one.kind == "removed")
        assert gone.key == f"{KEY}.3"


async def test_a_lock_is_written_in_time_and_says_that_it_is_on_its_way() -> None:
    server = bridge()
    async with paired(server, ("lock", "unlocked")) as (home, reports):
        assert (await home.command(f"{KEY}.3", "20", "lock", "locked")).success
        assert (server.written, server.timed) == ([((3, 22), 1)], [True])
        await reading(reports, "lock", "locking")
        server.report(3, 21, 1)
        await reading(reports, "lock", "locked")


async def test_each_press_of_a_button_is_an_event() -> None:
    server = bridge()
    async with paired(server, ("lock", "unlocked")) as (_, reports):
        for _ in range(2):
            server.report(4, 31, 0)
            await reading(reports, "press", "single")
        server.report(4, 31, 2)
        await reading(reports, "press", "long")


@pytest.mark.parametrize(("status", "problem"), [(-70402, "unreachable"), (70403, "unreachable"), (-70410, "refused")])
async def test_a_status_says_whether_the_same_may_work_later(status: int, problem: str) -> None:
    server = lamp()
    async with paired(server) as (home, _):
        server.status = status
        answer = await home.command(KEY, "8", "on_off", True)
        assert (answer.success, answer.problem) == (False, problem)


async def test_an_accessory_that_its_bridge_does_not_reach_is_not_seen() -> None:
    server = bridge()
    async with paired(server, ("lock", "unlocked")) as (home, reports):
        server.away = {3}
        await reading(reports, "reachable", False)
        sightings = home.sightings()
        await anyio.sleep(3 * 3600)
        seen = {one.key for one in iter(sightings.take, None) if one.why == "it answers"}
        assert seen == {KEY, f"{KEY}.2", f"{KEY}.4"}


async def test_an_accessory_that_restarts_is_back_within_five_seconds_and_got_no_command_twice() -> None:
    server = lamp()
    async with paired(server) as (home, reports):
        assert (await home.command(KEY, "8", "on_off", True)).success
        server.is_there = False
        server.drop()
        await reading(reports, "reachable", False)
        answer = await home.command(KEY, "8", "on_off", False)
        assert (answer.problem, server.written) == ("unreachable", [(ON, True)])
        await anyio.sleep(100)
        server.is_there = True
        with anyio.fail_after(5):
            await reading(reports, "reachable", True)
        assert (await home.command(KEY, "8", "on_off", False)).success
        assert server.written == [(ON, True), (ON, False)]


async def test_an_accessory_that_answers_wrongly_when_it_is_back_is_asked_again_at_once() -> None:
    server = lamp()
    async with paired(server) as (home, reports):
        server.is_there = False
        server.drop()
        await anyio.sleep(3600)
        listed, server.accessories = server.accessories, []
        server.is_there = True
        while not (await home.health()).troubles:  # noqa: ASYNC110 - it tells nobody
            await anyio.sleep(0.1)
        server.accessories = listed
        with anyio.fail_after(5):
            await reading(reports, "reachable", True)
        assert (await home.health()).troubles == ()


async def test_a_command_that_expires_while_the_accessory_hangs_does_not_come_later() -> None:
    server = lamp()
    async with paired(server) as (home, _):
        server.answers = anyio.Event()
        answer = await home.command(KEY, "8", "on_off", True, expires_after=2.0)
        assert (answer.problem, server.written) == ("unreachable", [])
        server.answers.set()
        await anyio.sleep(60)
        assert server.written == []


async def test_one_that_announces_the_id_of_another_does_not_end_its_connection() -> None:
    server = lamp()
    async with paired(server) as (home, reports):
        (link,) = server.links
        home.mdns.announce(server, ip_address="10.0.0.66")
        await anyio.sleep(1)
        assert server.links == [link]
        server.report(*ON, True)
        await reading(reports, "on_off", True)


async def test_after_more_events_than_can_wait_all_values_are_read() -> None:
    server = lamp()
    async with paired(server) as (home, reports):
        for number in range(MAX_EVENTS + 20):
            server.report(1, 10, number % 50)
        server.report(*ON, True)
        with anyio.fail_after(1):
            await reading(reports, "on_off", True)
        assert home.gateway.devices.counters.rejected == 21


async def test_values_without_events_are_read_now_and_then() -> None:
    server = lamp()
    async with paired(server) as (_, reports):
        server.find(1, 9)["value"] = True
        with anyio.fail_after(35):
            await reading(reports, "on_off", True)


async def test_an_accessory_that_sends_nonsense_is_rejected_and_then_heard_again() -> None:
    server = lamp()
    async with paired(server) as (home, reports):
        nonsense: list[HomekitValues] = [{(9, 9): {"value": 1}}, {(1, 9): {}}, {(1, 9): {"status": 0}}]
        for event in nonsense:
            server.send(event)
        server.report(*ON, "yes")
        server.report(*ON, True)
        await reading(reports, "on_off", True)
        assert home.gateway.devices.counters.rejected >= len(nonsense)


def sleeper() -> FakeServer:
    runtime = service(40, "239", characteristic(41, "23A", 2000, ["pr"]))
    return FakeServer(KEY, "Hall", accessory(1, "Hall", lamp_service(), runtime))


async def test_an_accessory_that_sleeps_is_not_unreachable_and_its_command_waits() -> None:
    server = sleeper()
    async with paired(server) as (home, reports):
        server.is_there = False
        server.drop()
        await reading(reports, "reachable", None)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(home.command, KEY, "8", "on_off", True)
            await anyio.sleep(20)
            server.is_there = True
        assert server.written == [(ON, True)]
        await reading(reports, "reachable", True)


async def test_a_command_that_expires_while_the_accessory_sleeps_does_not_come_later() -> None:
    server = sleeper()
    async with paired(server) as (home, reports):
        server.is_there = False
        server.drop()
        await reading(reports, "reachable", None)
        answers = [await home.command(KEY, "8", "on_off", True, expires_after=after) for after in (10.0, 0.0)]
        assert [one.problem for one in answers] == ["unreachable", "unreachable"]
        server.is_there = True
        await reading(reports, "reachable", True)
        assert server.written == []


async def test_an_accessory_over_thread_that_was_never_reached_may_sleep(tmp_path: Path) -> None:
    server, pairings = lamp(), tmp_path / "pairings.json"
    async with house(server, pairings=pairings) as home:
        await home.pair(server, CODE)
    server.service_type, server.is_there = "_hap._udp", False
    async with house(server, pairings=pairings) as home:
        await reading(home.reports(), "reachable", None)
        assert (await receive(home.sightings(), lambda one: one.name == "Hall")).service_type == "_hap._udp"


@pytest.mark.parametrize(("service_type", "attempts"), [("_hap._tcp", 2), ("_hap._udp", 1)])
async def test_a_new_address_ends_an_attempt_to_connect_but_none_over_thread(
    tmp_path: Path, service_type: str, attempts: int
) -> None:
    """A cancelled attempt over Thread would leave a socket of aiocoap open."""
    server, pairings = lamp(), tmp_path / "pairings.json"
    async with house(server, pairings=pairings) as home:
        await home.pair(server, CODE)
    server.service_type, server.answers, server.attempts = service_type, anyio.Event(), 0
    async with house(server, pairings=pairings) as home:
        home.mdns.announce(server, ip_address="10.0.0.66")
        await anyio.sleep(1)
        assert server.attempts == attempts


async def test_a_new_state_number_has_the_values_read_at_once() -> None:
    server = sleeper()
    async with paired(server) as (home, reports):
        server.find(1, 9)["value"] = True
        home.mdns.announce(server, state="2")
        with anyio.fail_after(1):
            await reading(reports, "on_off", True)


async def test_a_temperature_that_follows_a_mode_is_that_of_the_new_mode() -> None:
    """As in `thermostat_mode auto heating_setpoint 21` for ecobee's thermostats, in one command."""
    kinds = {"33": 1, "11": 20.5, "35": 19.0, "12": 17.0, "D": 25.0}
    listed = (characteristic(20 + at, kind, value) for at, (kind, value) in enumerate(kinds.items()))
    server = FakeServer(KEY, "Hall", accessory(1, "Hall", service(10, "4A", *listed)))
    async with paired(server, ("thermostat_mode", "heat")) as (home, reports):
        assert (await home.command(KEY, "10", "thermostat_mode", "auto")).success
        assert (await home.command(KEY, "10", "heating_setpoint", 21.0)).success
        assert server.written == [((1, 20), 3), ((1, 23), 21.0)]
        await reading(reports, "heating_setpoint", 21.0)


async def test_what_could_not_be_read_back_is_reported_once_it_is_read() -> None:
    server = bridge()
    async with paired(server) as (home, reports):
        server.away.add(2)
        assert (await home.command(f"{KEY}.2", "8", "level", 40.0)).success
        await anyio.sleep(1.0)
        server.away.clear()
        await reading(reports, "level", 40.0)


async def test_the_bridge_of_a_homebot_is_left_out() -> None:
    async with house(lamp()) as home:
        for name, model in (("Villa", "homebot"), ("Other", "Other bridge")):
            key = f"02:48:42:00:00:{len(name):02}"
            home.mdns.sight(name, dns_sd_type="_hap._tcp", txt_id=key, txt_sf="1", port="1", txt_md=model)
        await anyio.sleep(1)
        notes = "; ".join((await home.health()).notes)
        assert ("Other" in notes, "Villa" in notes) == (True, False)
