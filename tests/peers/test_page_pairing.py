"""Pairing in System: the seconds that are left, yes, no, a time that is over, a wrong code, and a second device."""

from collections.abc import Iterator
from typing import Any, ClassVar

import anyio
import pytest
from anyio import to_thread
from tests.peers.chromium import Page, axe_program, chromium, opened_page

from homebot.errors import RefusedError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.base import GatewayContext
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.gateways.pairing import PairingServices, UnpairedDevice
from homebot.graph import Node

OWNER = "of-the-owner"
BRIDGE, LOCK = "form[aria-label=Bridge]", "form[aria-label=Lock]"
TABLES: dict[str, object] = {
    "gateways": {
        "mqtt": {"root": "home425"},
        "hub": {"class": "tests.peers.test_page_pairing:Hub", "act": True},
    }
}
CODE = "123-45-678"
SHORT = 3  # seconds


class Hub(MemoryGateway):
    """Knows a bridge that is paired by its button, a lock by its code, and any device that has a code.

    Attributes:
        press: Takes whether the button is pressed, or pairing refused.
        paired: The keys that were paired.
    """

    running: ClassVar[list["Hub"]] = []

    def __init__(
        self, node: Node, settings: MemoryGatewaySettings | None = None, context: GatewayContext | None = None
    ) -> None:
        super().__init__(node, settings, context)
        PairingServices(self, node)
        self.within = 30.0
        self.press, self.pressed = anyio.create_memory_object_stream[bool](1)
        self.paired: list[str] = []
        self.running.append(self)

    async def pair(self, key: str, code: str) -> str:
        name = self._names[key]
        if key == "bridge":
            with anyio.move_on_after(self.within) as waiting:
                if not await self.pressed.receive():
                    raise RefusedError(
                        f"pairing {name}", "it is paired with another controller; remove it there, or reset it"
                    )
            if waiting.cancelled_caught:
                raise RefusedError(
                    f"pairing {name}", f"its button was not pressed within {self.within:g} s; press it and try again"
                )
        elif code != CODE:
            raise RefusedError(f"pairing {name}", "the code is wrong; if you are sure of it, try once more")
        self.paired.append(key)
        device = GatewayDevice(f"lamp of {name}", f"Lamp of {name}", (simple_part("light", settable=("on_off",)),))
        self.devices.put(device, "it was paired")
        return name

    async def unpair(self, key: str) -> str:
        raise AssertionError(key)

    def unpaired(self) -> Iterator[UnpairedDevice]:
        for key, name in self._names.items():
            if key not in self.paired:
                yield UnpairedDevice(device=key, name=name, takes_code=key != "bridge", within_s=self.within)

    _names: ClassVar = {"bridge": "Bridge", "lock": "Lock", "": "Matter"}


@pytest.fixture
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


async def test_a_bridge_is_paired_by_its_button_while_the_seconds_are_counted(browser: Any) -> None:
    async with opened_page(browser, tables=TABLES, token=OWNER) as own:
        await opened(own)
        await own.shows("Press the button on the device", BRIDGE)
        await own.click(f"{BRIDGE} button")
        first = await seconds_left(own)
        await to_thread.run_sync(own.until, lambda: 0 < left_in(own) < first - 1)
        assert not browser.find_element("css selector", f"{BRIDGE} button").is_enabled()
        Hub.running[-1].press.send_nowait(True)
        await own.shows("Bridge is paired.", BRIDGE)
        await own.shows("Found: Lamp of Bridge", BRIDGE)
        await own.lacks(f"{BRIDGE} button")
        axe = await to_thread.run_sync(axe_program)
        assert await to_thread.run_sync(own.complaints, axe) == []
        assert own.problems() == []


async def test_a_no_and_a_time_that_is_over_are_told_in_the_language_of_the_page(browser: Any) -> None:
    async with opened_page(browser, tables=TABLES, token=OWNER) as own:
        await opened(own, language="de")
        hub = Hub.running[-1]
        hub.press.send_nowait(False)
        await own.click(f"{BRIDGE} button")
        await own.shows("Bridge wurde nicht verbunden: es ist schon anderswo verbunden", BRIDGE)
        hub.within = SHORT
        await own.click(f"{BRIDGE} button")
        await own.shows(f"sein Knopf wurde in {SHORT} s nicht gedrückt", BRIDGE)
        await own.lacks(f"{BRIDGE} [role=timer]")
        assert hub.paired == []
        assert own.problems() == []


async def test_a_wrong_code_is_told_and_more_devices_may_have_a_code(browser: Any) -> None:
    async with opened_page(browser, tables=TABLES, token=OWNER) as own:
        await opened(own)
        for form, name in ((LOCK, "Lock"), ("form[aria-label=Matter]", "Matter")):
            await own.write(f"{form} input", "111-11-111")
            await own.click(f"{form} button")
            await own.shows(f"pairing {name} was refused: the code is wrong", form)
            await own.clear(f"{form} input")
            await own.write(f"{form} input", CODE)
            await own.click(f"{form} button")
            await own.shows(f"{name} is paired.", form)
            await own.shows(f"Found: Lamp of {name}", form)
        await own.lacks(f"{LOCK} button")
        assert browser.find_elements("css selector", "form[aria-label=Matter] button")
        assert CODE not in browser.page_source
        assert own.problems() == []


async def opened(own: Page, language: str = "en") -> None:
    """Open the step at which devices are paired."""
    await own.open(f"#token={OWNER}", shows="device")
    await to_thread.run_sync(own.browser.execute_script, f"localStorage.setItem('homebot.language', '{language}')")
    await own.open(f"?{language}#/setup/devices", shows="Bridge")


async def seconds_left(own: Page) -> int:
    await own.shows(" s ", f"{BRIDGE} [role=timer]")
    return left_in(own)


def left_in(own: Page) -> int:
    text: str = own.browser.find_element("css selector", f"{BRIDGE} [role=timer]").text
    return int("".join(filter(str.isdigit, text)))
