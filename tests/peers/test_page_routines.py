"""A routine that is only picked on the page: it is saved, and does its work in the house."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from anyio import to_thread
from tests.peers.chromium import Page, axe_program, chromium, opened_page
from tests.peers.test_page_touch import UNFIT

from homebot.house import World
from homebot.house.description import parse_world

SOURCE = Path(__file__).parents[2] / "src/homebot/web/source"
OWNER = "hunter2-and-some-more"
HOUSE = {
    "house": {"dialect": "zigbee2mqtt"},
    "rooms": {"hall": {}, "living_room": {}},
    "devices": {
        "hall_motion": {"kind": "motion", "room": "hall"},
        "kitchen_window": {"kind": "contact", "room": "living_room", "door": "outside"},
        "lamp": {"kind": "lamp", "room": "living_room"},
        "heating": {"kind": "thermostat", "room": "living_room"},
    },
}
HOME = {"name": "villa", "zone": "UTC", "latitude": 52.5, "longitude": 13.4}
LANGUAGES = ("de", "fr", "es", "nl", "it")
"""In the order of the columns of the page's texts."""

GROUP = "form [role=group]:nth-of-type({})"
WHEN, IF, DO = (GROUP.format(number) for number in (1, 2, 3))
SENTENCE = f"{DO} .choices label:nth-child(2) select"
ENTER = "\ue007"  # of WebDriver


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


@pytest.fixture
def world() -> World:
    return parse_world(HOUSE, "villa")


def choose(page: Page, place: str, device: str, sentence: str) -> None:
    """Choose a device by its name, and a sentence about it; the house for none."""
    devices, sentences = (f"{place} label:{which} select" for which in ("first-child", "nth-child(2)"))
    page.until(lambda: _chosen(page, devices, device) and _chosen(page, sentences, sentence))


def _chosen(page: Page, selector: str, text: str) -> bool:
    for option in page.browser.find_elements("css selector", f"{selector} option"):
        if option.text == text:
            option.click()
            return True
    return False


def pick(page: Page, place: str, device: str, sentence: str, *values: str) -> None:
    """Choose a sentence, write its values, and add it."""
    choose(page, place, device, sentence)
    for number, value in enumerate(values, 1):
        page.filled(f"{place} p input:nth-of-type({number})", value)
    page.clicked(f"{place} p button")


def begin(page: Page, shows: str = "There is no routine yet.") -> None:
    page.opened("#/routines", shows)
    page.clicked(".choices button")
    page.until(lambda: page.browser.find_elements("css selector", "form [role=group]"))


async def test_a_routine_that_is_only_picked_is_saved_and_does_its_work(browser: Any, world: World) -> None:
    def write(page: Page) -> None:
        page.opened(f"#token={OWNER}", "heating")
        begin(page)
        page.filled("[name=name]", "Warm light")
        pick(page, WHEN, "lamp", "lamp on")
        pick(page, IF, "Kitchen window", "kitchen_window closed")
        pick(page, DO, "heating", "heating 20 °C", "24.5")
        pick(page, DO, "times and the house", "notify …", 'Say "it"')
        pick(page, DO, "times and the house", "wait 5m", "90")
        pick(page, DO, "times and the house", "undo")
        text = page.browser.find_element("css selector", "textarea.code").get_attribute("value")
        assert text.splitlines()[2:] == [
            'when = ["lamp on"]',
            'if = ["kitchen_window closed"]',
            'do = ["heating 24.5 °C", "notify Say \\"it\\"", "wait 90m", "undo"]',
        ]
        page.clicked("form .buttons button")
        page.shown("added Warm light", "[role=alert]")
        page.opened("#/room/living_room", "heating")
        page.clicked("[role=switch][aria-label*=lamp]")
        page.shown("24.5")
        assert page.problems() == []

    async with opened_page(browser, world, {"home": HOME}, token=OWNER) as own:
        await to_thread.run_sync(write, own)


async def test_a_sentence_is_picked_by_keys_and_a_wrong_value_is_not_added(browser: Any, world: World) -> None:
    """Enter adds the sentence, and does not save a routine that is half written."""

    def write(page: Page) -> None:
        def steps() -> str:
            return str(browser.find_element("css selector", "[name=steps]").get_attribute("value"))

        page.opened(f"#token={OWNER}", "heating")
        begin(page)
        page.until(lambda: "wait 5m" in browser.find_element("css selector", SENTENCE).text)
        page.used(SENTENCE, lambda sentences: sentences.send_keys("w"))  # by its first letter
        page.filled(f"{DO} p input[aria-label='wait …m']", ENTER)
        assert steps() == ""
        page.filled(f"{DO} p input", f"2{ENTER}")
        page.until(lambda: steps() == "wait 2m")
        page.focused(SENTENCE)
        page.type("u")
        page.tabbed(f"{DO} p button")
        page.until(lambda: steps() == "wait 2m\nundo")
        page.focused(SENTENCE)
        choose(page, DO, "lamp", "lamp 100 %")
        page.filled(f"{DO} p input", f"300{ENTER}")
        assert steps() == "wait 2m\nundo"
        assert browser.execute_script(
            "return document.querySelector(arguments[0]).validity.rangeOverflow", f"{DO} p input"
        )
        assert page.problems() == []

    async with opened_page(browser, world, {"home": HOME}, token=OWNER) as own:
        await to_thread.run_sync(write, own)


@pytest.mark.parametrize(
    ("language", "scheme", "width", "size"),
    [("en", "light", 1280, 100), ("de", "dark", 320, 100), ("fr", "light", 390, 200), ("nl", "dark", 1280, 100)],
)
async def test_the_form_speaks_the_language_of_the_page_and_fits_each_width_with_large_text(
    browser: Any, world: World, language: str, scheme: str, width: int, size: int
) -> None:
    axe = await to_thread.run_sync(axe_program)
    texts = json.loads((SOURCE / "languages.json").read_text())
    own_texts = {text: row[LANGUAGES.index(language)] if language in LANGUAGES else text for text, row in texts.items()}
    window = {
        "en": "kitchen_window open for 5m",
        "de": "kitchen_window ist seit 5 Minuten offen",
        "fr": "kitchen_window est ouverte depuis 5 minutes",
        "nl": "kitchen_window staat al 5 minuten open",
    }[language]

    def look(page: Page) -> list[str]:
        page.prefer(scheme)
        page.resize(width, 900)
        page.opened(f"#token={OWNER}", "heating")
        browser.execute_script(f"localStorage.setItem('homebot.language', '{language}')")
        page.browser.get(f"{page.url}?{language}#/home")
        begin(page, own_texts["There is no routine yet."])
        choose(page, WHEN, "Kitchen window", window)
        page.settled()
        wrong: list[str] = browser.execute_script(UNFIT, size)
        if size == 100:
            wrong += page.complaints(axe)
        return wrong + ["too wide"] * bool(page.overflow()) + page.problems()

    async with opened_page(browser, world, {"home": HOME}, token=OWNER) as own:
        try:
            assert await to_thread.run_sync(look, own) == []
        finally:
            await to_thread.run_sync(browser.execute_script, "localStorage.clear()")
            own.become_computer()
