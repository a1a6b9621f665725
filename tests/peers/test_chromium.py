"""The hands of the tests of the page wait for what they use, on a page that is slow to draw."""

from collections.abc import Callable, Iterator

import pytest
from tests.peers.chromium import Page, chromium

SLOW = """
const [tag, done] = arguments;
document.body.innerHTML = "<a href='#'>before</a><div hidden></div>";
const place = document.querySelector("div");
const draw = () => {
  place.innerHTML = `<${tag} id=wanted style="width: 50px; height: 50px">x</${tag}>`;
  place.firstChild.onclick = () => (document.title = "pressed");
};
document.title = "";
draw();
setTimeout(() => (place.hidden = false), 400);
done();
"""
WANTED = "#wanted"
HANDS: dict[str, Callable[[Page], object]] = {
    "mouse": lambda page: page.clicked(WANTED),
    "touch": lambda page: page.tapped(WANTED),
    "keyboard": lambda page: page.tabbed(WANTED),
}


class Door:
    port, client_count = 1, 0


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    with chromium() as driver:
        driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
        yield Page(driver, Door())


@pytest.mark.parametrize("hand", HANDS)
def test_a_button_is_pressed_as_soon_as_it_is_shown(page: Page, hand: str) -> None:
    page.browser.execute_async_script(SLOW, "button")
    HANDS[hand](page)
    page.until(lambda: page.browser.title == "pressed")


def test_a_field_is_filled_as_soon_as_it_is_shown(page: Page) -> None:
    page.browser.execute_async_script(SLOW, "textarea")
    page.filled(WANTED, "y")
    assert page.browser.find_element("css selector", WANTED).get_attribute("value") == "y"
