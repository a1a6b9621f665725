"""A house whose devices speak other protocols than MQTT: servers on loopback, found by gateways of their own."""

from pathlib import Path

import anyio
import pytest
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE
from tests.simulated.families import FAMILIES, PROTOCOLS, families_with

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.errors import ConfigError
from homebot.graph import Node
from homebot.house import SimulatedLamp, World
from homebot.house.description import load_world, parse_world
from homebot.house.family import kinds_of
from homebot.house.network import HouseNetwork
from homebot.house.rooms import OUTSIDE, Room, Rooms
from homebot.house.simulated_device import Placed
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

pytestmark = [
    pytest.mark.slow,
    pytest.mark.rooms(
        "bthome", "esphome", "homeassistant", "homekit", "hue", "matter", "shelly", "wled", "zigbee2mqtt"
    ),
]

APP = Path(__file__).parents[2] / "examples" / "02_window_light"


class AwaitedLamp(SimulatedLamp):
    """A lamp of which tests wait until it is turned on."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.turned_on = anyio.Event()

    def _obey(self, command: str) -> tuple[str, ...]:
        if command == "on":
            self.turned_on.set()
        return super()._obey(command)


@pytest.mark.rooms("things")
async def test_the_app_of_the_examples_turns_on_a_lamp_of_every_family(monkeypatch: pytest.MonkeyPatch) -> None:
    """It was written for a window and a lamp that speak MQTT."""
    monkeypatch.syspath_prepend(str(APP))
    lamps = {name: AwaitedLamp(f"{name}_lamp") for name in families_with("lamp") if name != "matter_plug"}
    rooms = Rooms({OUTSIDE: Room(window=1.0), "hall": Room()}, [])
    world = World(rooms, [Placed(lamp, "hall", dialect=FAMILIES[name]) for name, lamp in lamps.items()])
    apps = {"window_light": {"class": "window_light:WindowLight"}}
    config = parse_config({"gateways": {"mqtt": {"root": "home425"}}, "apps": apps}, "test")
    async with alone_on_loopback(), MemoryBroker() as broker:
        host = HostedBroker.in_memory(broker)
        window = broker.make_client(MqttOptions.from_url(broker.url, client_id="window"))
        async with (
            Runtime(config, house=world, with_door=False, services=[host]) as runtime,
            Node(runtime.graph, "watcher") as watcher,
            window.connected(),
        ):
            with anyio.fail_after(PATIENCE):
                while len(await Devices(watcher).find("lights")) < len(lamps):  # noqa: ASYNC110
                    await anyio.sleep(0.2)
                while not all(lamp.turned_on.is_set() for lamp in lamps.values()):
                    await window.publish("home425/windows/kitchen/out", b"open")
                    await anyio.sleep(1)
    assert [lamp.is_on for lamp in lamps.values()] == [True] * len(lamps)


def test_the_example_has_a_device_of_every_family() -> None:
    assert set(FAMILIES.values()) <= set(load_world(PROTOCOLS).families())


def test_a_house_names_the_gateways_that_its_devices_need() -> None:
    assert HouseNetwork(["thesis"]).gateways() == {}
    assert HouseNetwork(["thesis", FAMILIES["wled"], FAMILIES["shelly_http"]]).gateways() == {
        "mdns": {"interfaces": ["127.0.0.1"], "announce": False}
    }


def test_an_error_names_the_devices_of_a_family() -> None:
    house = {"rooms": {"hall": {}}, "devices": {"door": {"kind": "lock", "room": "hall", "dialect": FAMILIES["wled"]}}}
    with pytest.raises(ConfigError, match=r"WledFamily' has no lock, only lamp"):
        parse_world(house, "test")


def test_an_error_of_an_unknown_dialect_names_all() -> None:
    house = {"rooms": {"hall": {}}, "devices": {"lamp": {"kind": "lamp", "room": "hall", "dialect": "telepathy"}}}
    with pytest.raises(ConfigError, match=r"must be one of homeassistant, .*zigbee2mqtt, got 'telepathy'"):
        parse_world(house, "test")
    assert kinds_of("telepathy") is None
