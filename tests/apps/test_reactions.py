"""Reactions of apps: conditions that last, runs by key, and the person behind a command; in virtual time."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import anyio
import pytest
from structlog.testing import capture_logs
from tests.apps.houses import flat, lamp, motion
from tests.control.conftest import Home, OpenHome

from homebot.apps import App, NoSettings
from homebot.apps.rooms import per_handle, per_room
from homebot.devices.handles import Handle, HandleChange, Light, OccupancySensor
from homebot.errors import UsageError
from homebot.graph import Graph, Node
from homebot.testing import virtual_house_of

pytestmark = pytest.mark.virtual_time

SetUp = Callable[[App], object]


def app_of(node: Node, set_up: SetUp) -> App:
    class Mine(App):
        async def run(self) -> None:
            set_up(self)

    return Mine(node, NoSettings())


async def started(home: Home, node: Node, set_up: SetUp) -> App:
    app = app_of(node, set_up)
    home.tasks.start_soon(app.serve)
    await anyio.sleep(0.01)
    return app


async def test_a_condition_counts_once_it_has_lasted(open_home: OpenHome) -> None:
    """Another value in between begins it anew; it is told once, until it ends."""
    quiet: list[tuple[float, str]] = []
    async with open_home() as home, Node(home.graph, "mine") as node:
        home.put("hall", "occupancy_sensor", readable=("occupancy",))
        await home.report("hall", "occupancy", True)
        begin = anyio.current_time()

        def on_quiet(change: HandleChange[OccupancySensor]) -> None:
            quiet.append((round(anyio.current_time() - begin), change.handle.id))

        await started(
            home,
            node,
            lambda app: app.on(app.devices.follow(OccupancySensor).became(occupied=False, lasting="5m"), on_quiet),
        )
        for wait, occupied in ((10, False), (200, True), (0, False), (400, False), (500, True), (60, False)):
            await anyio.sleep(wait)
            await home.report("hall", "occupancy", occupied)
        await anyio.sleep(400)
    assert [at for at, _ in quiet] == [210 + 300, 1170 + 300]


Told = list[tuple[int, str]]


@asynccontextmanager
async def quiet_rooms(open_home: OpenHome) -> AsyncIterator[tuple[Home, Told, App]]:
    """A hall with two motion sensors, and when all of a room have been quiet for five minutes."""
    told: Told = []
    async with open_home() as home, Node(home.graph, "mine") as node:
        for sensor in ("door", "stairs"):
            home.put(sensor, "occupancy_sensor", readable=("occupancy",), area="hall")
        begin = anyio.current_time()

        def on_quiet(change: HandleChange[OccupancySensor]) -> None:
            told.append((round(anyio.current_time() - begin), change.handle.name))

        def set_up(app: App) -> None:
            quiet = app.devices.follow(OccupancySensor).became(occupied=False, lasting="5m", key=per_room)
            app.on(quiet, on_quiet, key=per_room)

        yield home, told, await started(home, node, set_up)


async def test_a_room_is_quiet_once_all_its_sensors_are(open_home: OpenHome) -> None:
    """The first rule of the guide turned the lamp off while the second sensor saw somebody."""
    async with quiet_rooms(open_home) as (home, told, app):
        await home.report("stairs", "occupancy", True)
        await home.report("door", "occupancy", False)
        await anyio.sleep(1000)
        assert told == []
        await home.report("stairs", "occupancy", False)
        await anyio.sleep(250)
        await home.report("door", "occupancy", True)
        await anyio.sleep(10)
        assert [*app.waits] == []
        await home.report("door", "occupancy", False)
        await anyio.sleep(100)
        assert [(device, round(left)) for _, device, left in app.waits] == [("Door", 200)]
        await anyio.sleep(900)
        assert told == [(1260 + 300, "Door")]
        await home.report("stairs", "occupancy", True)
        await anyio.sleep(0.001)
        await home.report("stairs", "occupancy", False)
        await anyio.sleep(900)
    assert told == [(1560, "Door"), (2260 + 300, "Stairs")]


async def test_a_room_with_a_sensor_that_has_said_nothing_is_not_quiet(open_home: OpenHome) -> None:
    """Once that is gone, the others count, for as long as they have been quiet."""
    async with quiet_rooms(open_home) as (home, told, _):
        await home.report("door", "occupancy", False)
        await anyio.sleep(700)
        assert told == []
        home.gateway.devices.remove("stairs", "the test says so")
        await anyio.sleep(1)
    assert told == [(700, "Door")]


async def test_a_sensor_that_moves_counts_for_its_new_room(open_home: OpenHome) -> None:
    async with quiet_rooms(open_home) as (home, told, _):
        await home.report("stairs", "occupancy", True)
        await home.report("door", "occupancy", False)
        await anyio.sleep(400)
        home.put("stairs", "occupancy_sensor", readable=("occupancy",), area="attic")
        await anyio.sleep(1)
        assert told == [(400, "Door")]
        await home.report("stairs", "occupancy", False)
        await anyio.sleep(400)
    assert told == [(400, "Door"), (401 + 300, "Stairs")]


async def test_a_sensor_that_comes_begins_the_time_of_its_room_anew(open_home: OpenHome) -> None:
    async with quiet_rooms(open_home) as (home, told, _):
        for sensor in ("door", "stairs"):
            await home.report(sensor, "occupancy", False)
        await anyio.sleep(200)
        home.put("window", "occupancy_sensor", readable=("occupancy",), area="hall")
        await anyio.sleep(200)
        await home.report("window", "occupancy", False)
        await anyio.sleep(400)
    assert told == [(400 + 300, "Window")]


async def test_a_condition_that_is_to_last_is_known_while_it_does(open_home: OpenHome) -> None:
    """`homebot app list` had nothing of it."""
    async with open_home() as home, Node(home.graph, "mine") as node:
        home.put("hall", "occupancy_sensor", readable=("occupancy",))

        def on_quiet(change: HandleChange[OccupancySensor]) -> None: ...

        def set_up(app: App) -> None:
            app.on(app.devices.follow(OccupancySensor).became(occupied=False, lasting="5m"), on_quiet)

        app = await started(home, node, set_up)
        assert [*app.waits] == []
        await home.report("hall", "occupancy", False)
        await anyio.sleep(60)
        assert [(name, device, round(left)) for name, device, left in app.waits] == [("on_quiet", "Hall", 240)]
        await anyio.sleep(300)
        assert [*app.waits] == []


async def test_a_restart_begins_anew_but_for_what_the_device_proves(open_home: OpenHome) -> None:
    """It has reported that it is quiet for four minutes when the app starts."""
    quiet: list[float] = []
    async with open_home() as home, Node(home.graph, "mine") as node:
        home.put("hall", "occupancy_sensor", readable=("occupancy",))
        await home.report("hall", "occupancy", False)
        await anyio.sleep(240)
        begin = anyio.current_time()
        await started(
            home,
            node,
            lambda app: app.on(
                app.devices.follow(OccupancySensor).became(occupied=False, lasting="5m"),
                lambda _: quiet.append(round(anyio.current_time() - begin)),
            ),
        )
        await anyio.sleep(600)
    assert quiet == [60]


async def test_the_runs_of_one_key_do_not_touch_those_of_another(open_home: OpenHome) -> None:
    """A newer change of a lamp cancels what was done for the last one of that lamp alone."""
    ended: list[str] = []
    async with open_home() as home, Node(home.graph, "mine") as node:
        for key in ("one", "two"):
            home.put(key, "light", "on_off")

        async def wait(change: HandleChange[Light]) -> None:
            await anyio.sleep(10)
            ended.append(f"{change.handle.id} {change.handle.on}")

        await started(
            home,
            node,
            lambda app: app.on(app.devices.follow(Light, on=True), wait, mode="restart", key=per_handle),
        )
        await home.report("one", "on_off", True)
        await home.report("two", "on_off", True)
        await anyio.sleep(6)
        await home.report("one", "on_off", False)
        await anyio.sleep(6)
        assert [one.split()[1] for one in ended] == ["True"]
        await anyio.sleep(6)
    assert len(ended) == 2


async def test_a_handler_that_is_given_up_is_known_with_its_key(open_home: OpenHome) -> None:
    """The lamps of the other key go on; nothing named the one that is not served any more."""
    seen: list[str] = []
    async with open_home() as home, Node(home.graph, "mine") as node:
        for key in ("good", "bad"):
            home.put(key, "light", "on_off")

        def count(change: HandleChange[Light]) -> None:
            seen.append(change.handle.name)
            if change.handle.name == "Bad":
                raise ValueError("odd")

        app = await started(home, node, lambda app: app.on(app.devices.follow(Light), count, key=per_handle))
        for number in range(8):
            for key in ("good", "bad"):
                await home.report(key, "on_off", number % 2 == 0)
            await anyio.sleep(1)
        (runs,) = app.given_up
    assert runs.title == "handler count for 'Bad'"
    assert runs.trouble == "failed 5 times in a row and is not called any more (ValueError: odd)"
    assert (seen.count("Bad"), seen.count("Good")) == (5, 9)


async def test_a_press_is_the_wish_of_a_person_also_while_an_earlier_one_is_at_work(open_home: OpenHome) -> None:
    """The presence guard lets what it leads to through, and refuses the same without a press."""
    outcomes: list[str] = []
    async with open_home(presence_guard=True) as home, Node(home.graph, "mine") as node:
        home.put("lamp", "light", "on_off", area="hall")
        home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
        home.put("button", "generic_switch", readable=("press",), area="hall")
        await home.report("lamp", "on_off", True)
        await home.report("motion", "occupancy", True)

        async def pressed(change: HandleChange[Handle]) -> None:
            await anyio.sleep(5)
            outcomes.append((await (await home_lamp(app)).turn_off()).kind)
            await (await home_lamp(app)).turn_on()

        app = await started(
            home,
            node,
            lambda app: app.on(app.devices.follow(Handle).only("event"), pressed, mode="queued"),
        )
        await anyio.sleep(1)
        for _ in range(2):
            await home.report("button", "press", "single")
            await anyio.sleep(1)
        await anyio.sleep(30)
        assert (await (await home.handle(Light, "lamp")).turn_off()).kind == "refused"
    assert outcomes == ["confirmed", "confirmed"]


async def home_lamp(app: App) -> Light:
    (lamp,) = await app.devices.find(Light)
    return lamp


async def test_a_command_that_fails_is_logged_for_every_app(open_home: OpenHome) -> None:
    """One that makes no sense too; it costs neither the handler nor the other lamps."""
    outcomes: list[list[str]] = []
    async with open_home() as home, Node(home.graph, "mine") as node:
        home.put("sealed", "light", readable=("on_off",))
        home.put("lamp", "light", "on_off")
        app = await started(home, node, lambda _: None)
        with capture_logs() as lines:
            found = await app.each(Light.turn_on, sorted(await app.devices.find(Light), key=lambda one: one.name))
            outcomes.append([one.kind for one in found])
    assert outcomes == [["confirmed", "refused"]]
    assert [one["message"].partition(":")[0] for one in lines if one["event"] == "app.command_failed"] == ["Sealed"]


async def refuse(make: Callable[[App], object]) -> str:

    async with Node(Graph(), "mine") as node:
        with pytest.raises((UsageError, TypeError)) as caught:
            make(app_of(node, lambda _: None))
    return str(caught.value)


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda app: app.devices.follow(Light).became(onn=True), "did you mean on?"),
        (
            lambda app: app.devices.follow(Light).became(on=True, lasting="5 mons"),
            "lasting: '5 mons' is not a duration",
        ),
        (
            lambda app: app.devices.follow(Light).became(on=True, key="room"),
            "key: 'room' is not a function, such as per",
        ),
        (lambda app: app.devices.follow(Light).only("evnt"), "only() takes appeared, changed, event, mess"),
        (lambda app: app.devices.follow(5), "5 is neither a kind of handle, such as Light"),
        (lambda app: app.on(app.devices.follow(Light), "darken"), "handler: 'darken' is not a function"),
        (lambda app: app.on(app.devices.follow(Light), lambda: None), "handler: <lambda> is called with the change"),
        (lambda app: app.on(app.devices.follow(Light), print, key="room"), "key: 'room' is not a function"),
        (lambda app: app.start_task(None), "start_task() takes a coroutine function"),
        (lambda app: app.on(app.devices.follow(Light), print), "does not run yet"),
    ],
)
async def test_a_mistake_is_named(make: Callable[[App], object], problem: str) -> None:
    assert problem in await refuse(make)


def test_a_plain_run_is_refused_when_the_app_is_loaded() -> None:
    with pytest.raises(UsageError, match=r"Hall\.run is a plain function; write `async def run\(self\)`"):
        type("Hall", (App,), {"run": print})


@pytest.mark.rooms("homeassistant")
async def test_the_mode_is_checked_when_the_reaction_begins() -> None:
    world = flat(hall_lamp=lamp("hall"), hall_motion=motion("hall"))
    async with virtual_house_of(world=world) as house, Node(house.runtime.graph, "mine") as node:
        app = app_of(node, lambda app: app.on(app.devices.follow(Light), print, mode="restrat"))  # type: ignore[call-overload]
        with pytest.raises(ExceptionGroup) as caught:
            await app.serve()
    assert "did you mean restart?" in str(caught.value.exceptions[0])


@pytest.mark.parametrize(
    ("set_up", "text"),
    [
        (
            lambda app: app.on(app.devices.follow(Light, area="hall", name="oven"), print),
            "follow(Light, area='hall', name='oven')",
        ),
        (
            lambda app: app.on(app.devices.follow(Light, area="kitchen", name="lamp"), print),
            "follow(Light, area='kitchen', name='lamp')",
        ),
    ],
)
async def test_names_that_no_one_device_has_are_told_when_devices_had_time_to_come(
    open_home: OpenHome, set_up: SetUp, text: str
) -> None:
    async with open_home() as home, Node(home.graph, "mine") as node:
        home.put("lamp", "light", "on_off", area="hall")
        home.put("oven", "light", "on_off", area="kitchen")
        with capture_logs() as lines:
            await started(home, node, set_up)
            await anyio.sleep(290)
            assert [one for one in lines if one["event"] == "devices.nothing_fits"] == []
            await anyio.sleep(20)
        (line,) = [one for one in lines if one["event"] == "devices.nothing_fits"]
    assert line["message"].startswith(f"{text}: nothing in the house has all of these")


@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize("query", ["light", (), (None,)])
async def test_what_is_no_live_query_is_refused_when_the_reaction_begins(query: object) -> None:
    world = flat(hall_lamp=lamp("hall"))
    async with virtual_house_of(world=world) as house, Node(house.runtime.graph, "mine") as node:
        app = app_of(node, lambda app: app.on(query, print))  # type: ignore[call-overload]
        with pytest.raises(ExceptionGroup) as caught:
            await app.serve()
    assert "takes a live query, such as self.devices.follow(Light)" in str(caught.value.exceptions[0])
