"""The bridge in System: its code to scan and to type, until it is paired, for the owner alone."""

from collections.abc import Iterator
from typing import Any

import pytest
from anyio import to_thread
from tests.peers.chromium import axe_program, chromium, opened_page

pytest.importorskip("pyhap")

OWNER = "of-the-owner"
BRIDGE = ".box:has([role=img])"


@pytest.fixture
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


async def test_the_owner_sees_the_code_of_the_bridge_and_its_accessories(browser: Any) -> None:
    tables: dict[str, object] = {"homekit_bridge": {"export": ["light"], "port": 0}}
    async with opened_page(browser, tables=tables, token=OWNER) as own:
        await own.open(f"#token={OWNER}", shows="device")
        await own.open("#/system", shows="Apple Home")
        await own.shows("Add Accessory", BRIDGE)
        text = browser.find_element("css selector", f"{BRIDGE} b").text
        assert len(text.replace("-", "")) == len("12345678")
        assert browser.find_element("css selector", f"{BRIDGE} svg").size["width"] >= 200
        axe = await to_thread.run_sync(axe_program)
        assert await to_thread.run_sync(own.complaints, axe) == []
        assert own.problems() == []
