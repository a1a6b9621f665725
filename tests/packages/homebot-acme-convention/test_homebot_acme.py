"""The tests of the convention: golden bytes first, then a lamp in a running homebot."""

from __future__ import annotations

from importlib.metadata import entry_points

import pytest
from homebot_acme import Acme, AcmeSettings
from pydantic import ValidationError

from homebot import App, HandleChange, Light
from homebot.conventions.description import DescribedPart, DeviceAnnounced, DeviceWithdrawn, Publication
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.mqtt.settings import MqttGatewaySettings
from homebot.testing import TestHouse

INFO = b'{"name": "Desk", "dimmable": true}'


def test_the_package_is_installed() -> None:
    """Else nothing here would be shown of entry points."""
    assert "acme" in entry_points(group="homebot.mqtt_conventions").names


def announce(payload: bytes) -> DeviceAnnounced:
    (lamp,) = Acme(AcmeSettings()).read_message("acme/4711/info", payload, retained=True)
    assert isinstance(lamp, DeviceAnnounced)
    return lamp


def part_of(payload: bytes = INFO) -> DescribedPart:
    (part,) = announce(payload).parts
    return part


def test_an_announcement_is_a_light() -> None:
    lamp = announce(INFO)
    assert (lamp.key, lamp.name, lamp.identifiers) == ("4711", "Desk", ("id:acme-4711",))
    assert lamp.parts[0].part.service_type == "light"


def test_an_empty_announcement_takes_the_lamp_away() -> None:
    (gone,) = Acme(AcmeSettings()).read_message("acme/4711/info", b"", retained=False)
    assert isinstance(gone, DeviceWithdrawn)


@pytest.mark.parametrize("payload", [b"\xff", b"[]", b"{}", b'{"name": 7}'])
def test_what_the_maker_does_not_document_is_refused_and_counted(payload: bytes) -> None:
    convention = Acme(AcmeSettings())
    with pytest.raises(WireError, match="acme/4711/info"):
        convention.read_message("acme/4711/info", payload, retained=True)
    assert convention.rejected == 1


@pytest.mark.parametrize(
    ("payload", "readings"),
    [
        (b"on", {"on_off": True}),
        (b"off", {"on_off": False}),
        (b"on 40", {"on_off": True, "level": 40.0}),
        (b"on 101", {"on_off": True}),
        (b"\xff", {}),
        (b"", {}),
    ],
)
def test_a_report_is_read(payload: bytes, readings: dict[str, PlainValue]) -> None:
    assert part_of().codec.read("acme/4711/state", payload, retained=False) == readings


@pytest.mark.parametrize(
    ("capability", "value", "payload"),
    [("on_off", True, b"on"), ("on_off", False, b"off"), ("level", 40.4, b"on 40"), ("level", 0.0, b"off")],
)
def test_a_command_is_written(capability: str, value: PlainValue, payload: bytes) -> None:
    assert part_of().codec.write(capability, value) == (Publication("acme/4711/set", payload),)


def test_a_lamp_without_a_dimmer_refuses_to_be_dimmed() -> None:
    with pytest.raises(RefusedError, match="on_off"):
        part_of(b'{"name": "Desk"}').codec.write("level", 40.0)


class Dimmer(App):
    """Dims every light that was turned on fully."""

    async def run(self) -> None:
        async for change in self.devices.follow(Light, on=True):
            await self.dim(change)

    async def dim(self, change: HandleChange[Light]) -> None:
        lamp = change.handle
        if change.kind != "removed" and lamp.level == 100:
            await lamp.turn_on(level=20)
            self.node.log.info("dimmed", message=f"dimmed {lamp.name}, which was at {lamp.level:g} %")


@pytest.mark.homebot.with_args(Dimmer, config={"gateways": {"mqtt": {"conventions": ["acme"]}}})
async def test_an_app_finds_the_lamp_reads_it_and_sends_it_a_command(homebot: TestHouse) -> None:
    await homebot.says("acme/4711/info", INFO.decode())
    assert await homebot.hears("acme/4711/get") == ""
    await homebot.says("acme/4711/state", "on 100")
    assert await homebot.hears("acme/4711/set") == "on 20"


def test_a_setting_that_the_convention_does_not_have_is_an_error_that_names_it() -> None:
    with pytest.raises(ValidationError, match=r"acme\.colour\n.*unknown key; known are prefix"):
        MqttGatewaySettings.model_validate({"conventions": ["acme"], "acme": {"colour": "red"}})
