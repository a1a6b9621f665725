import json
from functools import partial
from pathlib import Path

import pytest
from tests.gateways.drivers.driver_host import KeepingHost, command, driven, found, running
from tests.gateways.served import served
from tests.integrations.shelly.simulated.web_device import ServedShelly
from tests.simulated.http.web_server import WebPeer, WebReply, WebRequest, WebServer

from homebot.devices.part import Part
from homebot.errors import LinkError, PeerError, RefusedError, UsageError, WireError
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.shelly.driver import ShellyDriver, ShellyDriverSettings

SERVICE = "_shelly._tcp.local."
PASSWORD = "correct horse"


def info(kind: str = "lamp") -> SimulatedDeviceInfo:
    return SimulatedDeviceInfo("home", kind, "Hall", "lights", "hall")


class Obeying(ServedShelly):
    """A lamp that does what it is told."""

    def __init__(self, kind: str = "lamp", password: str = "") -> None:
        super().__init__(info(kind), self.obey, password=password)
        self.told: list[str] = []
        self.begin(DeviceState(text="off", brightness=0.4, position=0.25), has_power=True)

    def obey(self, text: str) -> None:
        self.told.append(text)
        if text in {"on", "off"}:
            self.publish(DeviceState(text=text, is_on=text == "on", brightness=self.state.brightness))


def driver(port: int, host: KeepingHost, **settings: object) -> ShellyDriver:
    return ShellyDriver(found(SERVICE, port, gen="3"), ShellyDriverSettings.model_validate(settings), host)


class TestADimmer:
    async def test_is_described_with_its_parts_names_and_identifiers(self) -> None:
        shelly = Obeying()
        async with driven(shelly, driver) as (host, _):
            device = host.device
        assert (device.key, device.name) == ("Hall._shelly._tcp.local.", "Hall")
        (part,) = device.parts
        assert isinstance(part, Part)
        assert (part.id, part.service_type, part.reads, part.writes) == ("light:0", "light", (), ())
        assert (device.metadata["manufacturer"], device.metadata["generation"]) == ("Shelly", "3")
        assert shelly.id.partition("-")[2] in "".join(device.identifiers).replace(":", "")
        assert host.values == {("light:0", "on_off"): False, ("light:0", "level"): 40}

    async def test_is_commanded_and_its_notification_comes_back(self) -> None:
        shelly = Obeying()
        async with driven(shelly, driver) as (host, shelly_driver):
            await shelly_driver.perform(command("light:0", "on_off", True))
            await host.until(lambda: host.values["light:0", "on_off"] is True)
            await shelly_driver.perform(command("light:0", "level", 30.0, 2.0))
        assert shelly.told == ["on", "0.3"]
        assert json.loads(host.raw[0])["method"] == "NotifyStatus"

    async def test_reads_its_status_again(self) -> None:
        async with driven(Obeying(), driver) as (host, shelly_driver):
            host.values.clear()
            await shelly_driver.refresh(host.device.key, "light:0")
            await host.until(lambda: host.values.get(("light:0", "on_off")) is False)

    async def test_refuses_what_it_cannot(self) -> None:
        async with driven(Obeying(), driver) as (_, shelly_driver):
            with pytest.raises(RefusedError, match="cellar"):
                await shelly_driver.perform(command("cellar", "on_off", True))
            with pytest.raises(RefusedError):
                await shelly_driver.perform(command("light:0", "level", 200.0))
        with pytest.raises(LinkError, match="not connected"):
            await shelly_driver.perform(command("light:0", "on_off", True))


async def test_a_cover_goes_to_a_position() -> None:
    shelly = Obeying("cover")
    async with driven(shelly, driver) as (host, shelly_driver):
        await shelly_driver.perform(command("cover:0", "position", 60.0))
        await shelly_driver.perform(command("cover:0", "movement", "stopped"))
    assert host.values["cover:0", "position"] == 25
    assert shelly.told == ["0.6", "stop"]


class TestPasswords:
    async def test_calls_are_signed(self, tmp_path: Path) -> None:
        (tmp_path / "password").write_text(f"{PASSWORD}\n")
        (tmp_path / "password").chmod(0o600)
        shelly = Obeying(password=PASSWORD)
        make = partial(driver, password_file=tmp_path / "password")
        async with driven(shelly, make) as (_, shelly_driver):
            await shelly_driver.perform(command("light:0", "on_off", True))
        assert shelly.told == ["on"]
        assert shelly.refused_calls == 1

    async def test_a_device_has_a_password_of_its_own(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("ALL", "wrong")
        monkeypatch.setenv("OWN", PASSWORD)
        shelly = Obeying(password=PASSWORD)
        own = {shelly.id.upper(): {"password_env": "OWN"}}
        async with driven(shelly, partial(driver, password_env="ALL", devices=own)) as (host, _):
            assert ("light:0", "on_off") in host.values

    async def test_without_one_the_device_is_listed_and_the_error_says_what_to_do(self) -> None:
        host, shelly = KeepingHost(), Obeying(password=PASSWORD)
        async with served(shelly):
            with pytest.raises(RefusedError, match=r"give password_file or password_env"):
                await driver(shelly.server.port, host).run()
        assert (host.device.name, host.device.parts) == ("Hall", ())
        assert host.device.identifiers

    async def test_a_wrong_one_is_refused_and_not_shown(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("WRONG", "battery staple")
        host, shelly = KeepingHost(), Obeying(password=PASSWORD)
        async with served(shelly):
            with pytest.raises(RefusedError, match="refuses the password") as caught:
                await driver(shelly.server.port, host, password_env="WRONG").run()
        assert "staple" not in str(caught.value)
        assert shelly.refused_calls == 2

    @pytest.mark.parametrize(
        ("settings", "named"),
        [
            ({"password_env": "NOT_THERE"}, "password_env"),
            ({"devices": {"shellyplus1-a": {"password_env": "NOT_THERE"}}}, "devices.shellyplus1-a.password_env"),
        ],
    )
    def test_the_configuration_is_checked_first(self, settings: dict[str, object], named: str) -> None:
        with pytest.raises(UsageError, match=named):
            ShellyDriver.check(ShellyDriverSettings.model_validate(settings))


class Strange:
    """A server that answers as it is told, and sends frames to whoever calls."""

    def __init__(self, about: object, *frames: bytes) -> None:
        self.about = json.dumps(about).encode()
        self.frames = frames

    def answer(self, request: WebRequest) -> WebReply:
        return WebReply(self.about) if request.path == "/shelly" else WebReply(b"", 404)

    def greet(self, peer: WebPeer, path: str) -> bool:
        del peer
        return path == "/rpc"

    def receive(self, peer: WebPeer, message: bytes) -> None:
        del message
        for frame in self.frames:
            peer.send(frame)


PLUS1 = {"id": "shellyplus1-a8032abe54dc", "mac": "A8032ABE54DC", "gen": 2, "app": "Plus1", "auth_en": False}


async def test_a_device_of_the_first_generation_is_described_and_no_more() -> None:
    """Shelly Gen1 API, /shelly."""
    host = KeepingHost()
    server = WebServer(
        Strange({"type": "SHSW-25", "mac": "8CAAB55F44E2", "auth": False, "fw": "20230913-112234/v1.14.0-gcb84623"})
    )
    async with served(server), running(driver(server.port, host)):
        await host.until(lambda: bool(host.devices))
    assert host.device.parts == ()
    assert host.device.metadata["model"] == "SHSW-25"
    assert host.device.metadata["generation"] == "1"
    assert "8caab55f44e2" in "".join(host.device.identifiers).replace(":", "").lower()


@pytest.mark.parametrize("about", [[], {}, {"gen": 2}, {"gen": 2, "id": "a/#"}, {"gen": 2, "id": 7}, "x"])
async def test_an_answer_of_another_device_is_an_error_of_ours(about: object) -> None:
    server = WebServer(Strange(about))
    async with served(server):
        with pytest.raises(WireError, match="Hall"):
            await driver(server.port, KeepingHost()).run()


async def test_a_device_that_sends_rubbish_is_left_after_twenty_messages() -> None:
    host = KeepingHost()
    frames = [b"", b"[]", b"{", b'{"id": 7}', b'{"id": true}', b'{"method": 5}', b"\xff", b'{"id": 1e400}'] * 5
    server = WebServer(Strange(PLUS1, *frames))
    async with served(server):
        with pytest.raises(WireError, match="20 invalid messages"):
            await driver(server.port, host).run()
    assert len(host.rejected) == 20


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        ({"code": -114, "message": "Unavailable"}, LinkError),
        ({"code": -103, "message": "Argument 'on', required but missing!"}, RefusedError),
        ({"code": 404, "message": "No handler for Shelly.GetConfig"}, RefusedError),
        ({}, RefusedError),
        ("x", RefusedError),
        ({"code": 401, "message": "{}"}, RefusedError),
    ],
)
async def test_errors_of_calls_are_ours(error: object, kind: type[Exception]) -> None:
    server = WebServer(Strange(PLUS1, json.dumps({"id": 1, "src": "x", "error": error}).encode()))
    async with served(server):
        with pytest.raises(kind):
            await driver(server.port, KeepingHost()).run()


@pytest.mark.parametrize(
    "message",
    [
        "",
        "{}",
        "[]",
        '{"realm": 1, "nonce": 1, "algorithm": "SHA-256"}',
        '{"realm": "x", "nonce": true, "algorithm": "SHA-256"}',
        '{"realm": "x", "nonce": 1, "algorithm": "MD5"}',
    ],
)
async def test_a_strange_challenge_is_an_error_of_ours(message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OWN", PASSWORD)
    frame = {"id": 1, "src": "x", "error": {"code": 401, "message": message}}
    server = WebServer(Strange(PLUS1, json.dumps(frame).encode()))
    async with served(server):
        with pytest.raises(PeerError):
            await driver(server.port, KeepingHost(), password_env="OWN").run()
