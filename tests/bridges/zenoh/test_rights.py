"""The rights on Zenoh, with sessions of the library itself as robots that try more than they may."""

import asyncio
import json
import stat
import time
from collections.abc import AsyncIterator, Callable, Iterable, Mapping
from contextlib import asynccontextmanager, nullcontext
from functools import partial
from pathlib import Path

import anyio
import anyio.lowlevel
import pytest
import zenoh
from anyio import to_thread
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import HOME, door_of, house_rights, log_in

from homebot.bridges.zenoh.rights import WireRights, check_apart
from homebot.bridges.zenoh.session import WireQuery, WireSample, ZenohSession, open_session
from homebot.errors import UsageError
from homebot.features.ros2.certificate import make_certificate
from homebot.graph.qos import QoSProfile
from homebot.messages.interfaces.settings import RosSettings

IMPORT = {"rosie": ("/rosie/**",), "bob": ("/bob/**",)}
WORDS = "0/{}/words/T/H"
NODE = "@ros2_lv/0/{}/0/0/NN/%/{}/brain"
READ = ("MP", "SS", "AS")


class House:
    """The session of a house that is the router at *address*, with what came from robots, by the key."""

    def __init__(self, session: ZenohSession, address: str) -> None:
        self.session, self.address = session, address
        self.heard: dict[str, list[bytes]] = {}
        self.news = anyio.Event()
        self.tokens: list[str] = []
        self.kept: list[object] = []

    def listen(self, robot: str) -> None:
        heard = self.heard.setdefault(robot, [])

        def hear(sample: WireSample) -> None:
            heard.append(sample.payload)
            self.news.set()

        self.kept.append(self.session.subscribe(WORDS.format(robot), QoSProfile(), hear))

    async def hears(self, robot: str, session: zenoh.Session, payload: bytes) -> None:
        """Let *session* say *payload* as *robot* until it is heard: there is no reader at first."""
        with anyio.fail_after(PATIENCE):
            while payload not in self.heard[robot]:
                self.news = anyio.Event()
                session.put(WORDS.format(robot), payload)
                with anyio.move_on_after(0.05):
                    await self.news.wait()


@asynccontextmanager
async def house(
    address: str = "", imports: Mapping[str, tuple[str, ...]] = IMPORT, **files: Path
) -> AsyncIterator[House]:
    address = address or f"tcp/127.0.0.1:{reserve_port()}"
    table = {"listen": address, "export": ("/house/*",), "import": imports, **files}
    settings = RosSettings.model_validate(table)
    async with (
        open_session(settings, house_rights(settings)) as session,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(session.run)
        made = House(session, address.replace("[::]", "127.0.0.1"))
        made.listen("rosie")
        made.listen("bob")
        made.kept.append(session.watch_tokens("@ros2_lv/0/**", lambda text, _: made.tokens.append(text)))
        yield made
        tasks.cancel_scope.cancel()


async def robot(house: House, name: str, ca: Path | None = None) -> zenoh.Session:
    return await to_thread.run_sync(partial(log_in, house.address, name, ca=ca, patience=PATIENCE))


async def asked(get: Callable[..., Iterable[zenoh.Reply]], key: str) -> list[zenoh.Sample]:
    """Return the answers, which are waited for in a thread."""
    replies = await to_thread.run_sync(lambda: list(get(key, timeout=PATIENCE)))
    return [one.ok for one in replies if one.ok is not None]


async def test_a_robot_says_what_is_imported_from_it_and_nothing_in_the_name_of_another() -> None:
    async with house() as villa:
        with await robot(villa, "rosie") as rosie, await robot(villa, "bob") as bob:
            bob.put(WORDS.format("rosie"), b"from bob")
            await villa.hears("bob", bob, b"mine")
            bob.put(WORDS.format("rosie"), b"from bob")
            await villa.hears("bob", bob, b"mine too")  # what came before it has come by now
            await villa.hears("rosie", rosie, b"from rosie")
        assert set(villa.heard["rosie"]) == {b"from rosie"}


@pytest.mark.parametrize(("name", "secret"), [("", ""), ("rosie", "a secret of bob"), ("eve", "a secret of eve")])
async def test_nobody_connects_without_the_secret_of_a_token(name: str, secret: str) -> None:
    async with house() as villa:
        with pytest.raises(zenoh.ZError, match="Unable to connect"):
            await to_thread.run_sync(log_in, villa.address, name, secret)


async def test_nobody_connects_to_a_router_without_robots() -> None:
    async with house(imports={}) as villa:
        with pytest.raises(zenoh.ZError, match="Unable to connect"):
            await to_thread.run_sync(log_in, villa.address)


async def test_a_robot_asks_what_is_exported_and_nothing_else() -> None:
    def answer(query: WireQuery) -> None:
        query.reply(lambda: b"yes", b"")

    async with house() as villa:
        villa.kept += [villa.session.serve(f"0/{name}/T/H", answer) for name in ("house/lamp", "devices/command")]
        with await robot(villa, "rosie") as rosie:
            with anyio.fail_after(PATIENCE):
                while not (answers := await asked(rosie.get, "0/house/lamp/T/H")):
                    await anyio.lowlevel.checkpoint()
            assert [bytes(one.payload) for one in answers] == [b"yes"]
            assert await asked(rosie.get, "0/devices/command/T/H") == []
            assert await asked(rosie.get, "0/**") == []


async def test_a_robot_does_not_serve_what_is_not_imported_from_it() -> None:
    def answer(query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, b"yes")

    async with house() as villa:
        with await robot(villa, "rosie") as rosie:
            rosie.declare_queryable("0/devices/command/T/H", answer, complete=True)
            rosie.declare_queryable("0/rosie/dock/T/H", answer, complete=True)
            with anyio.fail_after(PATIENCE):
                while (dock := await villa.session.ask("0/rosie/dock/T/H", b"", b"", PATIENCE)) is None:
                    await anyio.lowlevel.checkpoint()
            assert dock == b"yes"
            assert await villa.session.ask("0/devices/command/T/H", b"", b"", PATIENCE) is None


async def test_of_several_robots_none_has_the_nodes_of_another_or_knows_them() -> None:
    async with house() as villa:
        own = NODE.format(villa.session.id, "%").replace("brain", "ros2")
        villa.kept.append(villa.session.declare_token(own))
        with await robot(villa, "rosie") as rosie, await robot(villa, "bob") as bob:
            mine, his = (NODE.format(one.zid(), f"%{name}") for one, name in ((rosie, "rosie"), (bob, "bob")))
            tokens = [bob.liveliness().declare_token(NODE.format(bob.zid(), "%rosie"))]
            tokens += [rosie.liveliness().declare_token(mine), bob.liveliness().declare_token(his)]
            with anyio.fail_after(PATIENCE):
                while not {mine, his} <= set(villa.tokens):
                    await anyio.lowlevel.checkpoint()
                known = [str(one.key_expr) for one in await asked(rosie.liveliness().get, "@ros2_lv/0/**")]
            assert set(villa.tokens) - {own} == {mine, his}
            assert set(known) == {own, mine}


def router_of_a_robot(address: str) -> zenoh.Session:
    settings = {"mode": "router", "listen": {"endpoints": [address]}, "scouting": {"multicast": {"enabled": False}}}
    return zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))


async def test_nothing_passes_from_one_router_to_another_that_the_house_connects_to() -> None:
    addresses = [f"tcp/127.0.0.1:{reserve_port()}" for _ in range(2)]
    table = {"connect": addresses, "export": ("/house/*",), "import": {"rosie": ("/rosie/**",)}}
    settings = RosSettings.model_validate(table)
    with router_of_a_robot(addresses[0]) as one, router_of_a_robot(addresses[1]) as other:
        async with (
            open_session(settings, WireRights.of_routers(settings, HOME, None)) as session,
            anyio.create_task_group() as tasks,
        ):
            tasks.start_soon(session.run)
            villa, there, ended = House(session, ""), [], anyio.Event()
            villa.listen("rosie")
            loop = asyncio.get_running_loop()
            other.declare_subscriber(WORDS.format("rosie"), lambda sample: there.append(sample.payload))
            other.declare_subscriber(WORDS.format("house"), lambda _: loop.call_soon_threadsafe(ended.set))
            writer = session.publish(WORDS.format("house"), QoSProfile())
            await villa.hears("rosie", one, b"hello")
            with anyio.fail_after(PATIENCE):
                while not ended.is_set():
                    one.put(WORDS.format("rosie"), b"hello")
                    writer.put(b"end", attachment=b"")
                    with anyio.move_on_after(0.05):
                        await ended.wait()
            tasks.cancel_scope.cancel()
        assert there == []


@pytest.fixture
def made(tmp_path: Path) -> Path:
    """Return a folder with the certificates of this router and of another one."""
    make_certificate(tmp_path / "router.crt", tmp_path / "router.key", ["villa.lan"], time.time())
    make_certificate(tmp_path / "other.crt", tmp_path / "other.key", ["127.0.0.1"], time.time())
    return tmp_path


async def test_others_trust_the_router_by_the_file_of_its_certificate(made: Path) -> None:
    address, certificate = f"tls/[::]:{reserve_port()}", made / "router.crt"
    async with house(address, cert_file=certificate, key_file=made / "router.key") as villa:
        with await robot(villa, "rosie", certificate) as rosie:
            await villa.hears("rosie", rosie, b"hello")
        for ca in (None, made / "other.crt"):
            with pytest.raises(zenoh.ZError, match="Unable to connect"):
                await to_thread.run_sync(log_in, villa.address, "rosie", "", ca)
        with pytest.raises(zenoh.ZError, match="Unable to connect"):
            await to_thread.run_sync(log_in, villa.address.replace("tls/", "tcp/"), "rosie")


async def test_a_certificate_with_the_key_of_another_is_refused(made: Path) -> None:
    address = f"tls/127.0.0.1:{reserve_port()}"
    with pytest.raises(UsageError, match="does not match the certificate"):
        async with house(address, cert_file=made / "router.crt", key_file=made / "other.key"):
            pass


def test_a_certificate_is_never_written_over_and_its_key_is_for_its_owner_alone(made: Path) -> None:
    assert stat.S_IMODE((made / "router.key").stat().st_mode) == 0o600
    with pytest.raises(UsageError, match=r"router\.crt is there"):
        make_certificate(made / "router.crt", made / "new.key", [], time.time())


@pytest.mark.parametrize(
    ("rosie", "bob", "is_apart"),
    [
        ("/rosie/**", "/bob/**", True),
        ("/tf", "/tf", False),
        ("/rosie/**", "/*/pose", False),
        ("/rosie/*", "/rosie/a/b", True),
        ("/left_*", "/left_cam", False),
    ],
)
def test_no_name_may_come_from_two_robots(rosie: str, bob: str, *, is_apart: bool) -> None:
    settings = RosSettings.model_validate({"import": {"rosie": (rosie,), "bob": (bob,)}})
    with nullcontext() if is_apart else pytest.raises(UsageError, match="have names in common"):
        check_apart(settings)


def test_a_token_that_has_ended_or_may_not_read_has_less() -> None:
    settings = RosSettings.model_validate({"export": ("/map",), "import": IMPORT})
    door = door_of("rosie", "bob", scope=())
    ended = door.tokens["bob"].model_copy(update={"until": 100.0})
    door = door.model_copy(update={"tokens": {**door.tokens, "bob": ended}})
    rights = WireRights.of_tokens(settings, door, HOME, {}, now=100.0)
    assert list(rights.passwords) == ["rosie"]
    assert not any("/map/" in key for rule in rights.rules for key in rule.keys)
    assert "secret" not in repr(rights)


@pytest.mark.parametrize("pattern", ["/**", "/*", "/*/pose", "/*/*/*/*", "/ros*/**", "/0/**"])
def test_names_that_could_be_keys_of_rmw_zenoh_are_none_behind_a_bridge(pattern: str) -> None:
    settings = RosSettings.model_validate({"import": {"rosie": (pattern,)}})
    for rights in (house_rights(settings), WireRights.of_routers(settings, HOME, None)):
        keys = [key for rule in rights.rules for key in rule.keys]
        assert all(key.startswith(("0/", "@ros2_lv/")) or key == "@/*/@ros2_lv/**" for key in keys)


def test_the_keys_of_a_bridge_are_no_others() -> None:
    settings = RosSettings.model_validate({"import": {"rosie": ("/rosie/*", "/tf")}})
    keys = {key for rule in house_rights(settings).rules for key in rule.keys if key[0] not in "0@"}
    plain = ("rosie/*", "rosie/*/_action/*", "tf", "tf/_action/*")
    assert keys == {*plain, *(f"{key}/@adv/**" for key in plain)}
    given = {key for rule in house_rights(settings).rules for key in rule.keys if key.startswith("@/*/@ros2_lv/")}
    names = ("rosie§$*", "tf")
    assert given == {"@/*/@ros2_lv/**", *(f"@/*/@ros2_lv/{kind}/{name}/**" for kind in READ for name in names)}


def test_a_machine_with_the_name_of_a_token_is_refused() -> None:
    settings = RosSettings.model_validate({"import": {"rosie": ()}})
    with pytest.raises(UsageError, match="a machine and a token are both called rosie"):
        house_rights(settings, "rosie")
