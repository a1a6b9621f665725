import json

import pytest
from tests.gateways.drivers.driver_host import KeepingHost, command, driven, found, night, running
from tests.gateways.served import served
from tests.integrations.wled.simulated.web_device import ServedWled
from tests.simulated.http.web_server import WebPeer, WebReply, WebRequest, WebServer

from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.drivers.base import DriverSettings
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.wled.driver import WledDriver


class Obeying(ServedWled):
    """A strip that does what it is told."""

    def __init__(self) -> None:
        super().__init__(SimulatedDeviceInfo("home", "lamp", "Shelf", "lights", "hall"), self.obey)
        self.told: list[str] = []
        self.begin(DeviceState(text="off", brightness=0.4, kelvin=2700), has_power=True)

    def obey(self, text: str) -> None:
        self.told.append(text)
        state = self.state
        if text in {"on", "off"}:
            state = DeviceState(text=text, is_on=text == "on", brightness=state.brightness, kelvin=state.kelvin)
        elif not text.endswith("K"):
            state = DeviceState(text=text, is_on=True, brightness=float(text), kelvin=state.kelvin)
        self.state = state


SIGNAL = ("signal", "signal_strength")  # which is reported last


def driver(port: int, host: KeepingHost) -> WledDriver:
    return WledDriver(found("_wled._tcp.local.", port), DriverSettings(), host)


async def test_a_strip_is_described_with_its_parts_and_reported() -> None:
    async with driven(Obeying(), driver, SIGNAL) as (host, _):
        device = host.device
    assert (device.key, device.name) == ("Hall._wled._tcp.local.", "Shelf")
    assert device.metadata["sw_version"] == "0.15.0"
    assert device.identifiers
    lamp = device.parts[0]
    assert (lamp.id, lamp.service_type) == ("", "light")
    assert {one.name for one in lamp.capabilities} == {"on_off", "level", "color", "color_temperature", "effect"}
    assert [one.id for one in device.parts[1:]] == ["sync_send", "sync_receive", "nightlight", "live", "signal"]
    known = {("", "on_off"): False, ("", "level"): 40, ("", "effect"): "Solid", ("live", "state"): False, SIGNAL: -62}
    assert host.values.items() >= known.items()
    assert host.refused == []


async def test_changes_by_others_are_pushed() -> None:
    strip = Obeying()
    async with driven(strip, driver, SIGNAL) as (host, _):
        await host.until(lambda: bool(strip.server.peers))
        strip.is_live = True
        strip.publish(DeviceState(text="on", is_on=True, brightness=1.0))
        await host.until(lambda: host.values["", "on_off"] is True and host.values["live", "state"] is True)
    assert json.loads(host.raw[-1])["state"]["on"] is True


@pytest.mark.parametrize(
    ("part", "capability", "value", "told"),
    [
        ("", "on_off", True, ["on"]),
        ("", "on_off", False, ["off"]),
        ("", "level", 20.0, ["0.2"]),
        ("", "color_temperature", 4012.0, ["4012 K", "on"]),
        ("", "color", (240.0, 100.0), ["on"]),
        ("", "effect", "Rainbow", ["on"]),
        ("sync_send", "on_off", True, []),
    ],
)
async def test_the_strip_is_commanded(part: str, capability: str, value: PlainValue, told: list[str]) -> None:
    strip = Obeying()
    async with driven(strip, driver, SIGNAL) as (host, wled):
        await wled.perform(command(part, capability, value, 1.0))
        await host.until(lambda: host.values[part, capability] == value or capability == "color_temperature")
    assert strip.told == told
    if capability == "color":
        assert strip.segment["col"] == [[0, 0, 255]]
    assert strip.sync == {"send": part == "sync_send", "recv": True}


async def test_one_state_sets_all_that_the_strip_shall_be() -> None:
    strip = Obeying()
    async with driven(strip, driver, SIGNAL) as (_, wled):
        assert set(await wled.perform(night(""))) == {"level", "color_temperature", "on_off"}
    assert strip.told == ["2700 K", "0.0314"]


async def test_presets_are_options_and_read_anew_when_they_change() -> None:
    strip = Obeying()
    strip.presets = {"0": {}, "3": {"n": "Evening", "on": True}}
    async with driven(strip, driver, ("preset", "option")) as (host, wled):
        assert host.values["preset", "option"] is None
        await wled.perform(command("preset", "option", "Evening"))
        await host.until(lambda: host.values["preset", "option"] == "Evening")
        assert strip.preset == 3
        strip.presets |= {"4": {"playlist": {"ps": [3]}, "n": "Party"}}
        strip.preset = 4
        strip.show()
        await host.until(lambda: host.values["preset", "option"] == "Party")
    assert host.refused == []


async def test_an_impossible_command_is_refused_and_not_sent() -> None:
    strip = Obeying()
    async with driven(strip, driver) as (_, wled):
        for part, capability, value in (
            ("cellar", "on_off", True),
            ("", "level", 101.0),
            ("", "effect", "RSVD"),
            ("", "volume", 1.0),
            ("live", "state", True),
        ):
            with pytest.raises(RefusedError):
                await wled.perform(command(part, capability, value))
    with pytest.raises(LinkError, match="not connected"):
        await wled.perform(command("", "on_off", True))
    assert strip.told == []


class Strange:
    """A server that answers with a text, and sends messages to each WebSocket."""

    def __init__(self, answer: object, *messages: bytes, status: int = 200) -> None:
        self.reply = WebReply(json.dumps(answer).encode(), status)
        self.messages = messages

    def answer(self, request: WebRequest) -> WebReply:
        return self.reply if request.path == "/json/si" else WebReply(b"[]")

    def greet(self, peer: WebPeer, path: str) -> bool:
        del path
        for message in self.messages:
            peer.send(message)
        return bool(self.messages)

    def receive(self, peer: WebPeer, message: bytes) -> None:
        del peer, message


@pytest.mark.parametrize("answer", [[], {}, {"state": {}}, {"state": [], "info": {}}, "x", None])
async def test_an_answer_of_another_device_is_an_error_of_ours(answer: object) -> None:
    server = WebServer(Strange(answer))
    async with served(server):
        with pytest.raises(WireError, match="no state or no info"):
            await driver(server.port, KeepingHost()).run()


async def test_a_controller_without_websockets_is_asked() -> None:
    host = KeepingHost()
    server = WebServer(Strange({"state": {"on": True, "bri": 255}, "info": {"ws": -1}}))
    async with served(server), running(driver(server.port, host)):
        await host.until(lambda: ("", "on_off") in host.values)
    assert host.values["", "on_off"] is True


async def test_a_controller_that_is_busy_is_asked_again_and_then_given_up() -> None:
    server = WebServer(Strange({"error": 3}, status=503))
    async with served(server):
        with pytest.raises(LinkError, match="503"):
            await driver(server.port, KeepingHost()).run()
