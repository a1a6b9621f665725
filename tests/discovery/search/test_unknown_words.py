"""A query with a misspelt word is refused with what was meant: it would find nothing, or, negated, everything."""

import pytest
from tests.discovery.announcements import announce, part_of

from homebot.discovery import DeviceIndex
from homebot.discovery.search.unknown_words import check_words
from homebot.errors import RefusedError, UsageError
from homebot.words.queries import parse_query


@pytest.fixture
def house() -> DeviceIndex:
    index = DeviceIndex(forget_after=1000.0)
    lamp = part_of("light", "on_off", id="l", writes=("a",))
    index.observe(announce("a", lamp, ids=("id:desk",), name="Desk lamp", area="Kitchen"))
    index.observe(announce("b", lamp, ids=("id:den",), name="Den lamp", area="Deny"))
    index.sort()
    return index


def refusal(house: DeviceIndex, text: str) -> str:
    try:
        check_words(parse_query(text), house.postings, house.owner.plan, house.devices)
    except UsageError as exc:
        return str(exc)
    except RefusedError as exc:
        return exc.reason
    return ""


REFUSED = {
    "type=xyzzy": "'xyzzy' is not a device type, and no device was announced as one; known are ",
    "lights in kichen": "no device is in 'kichen'; did you mean kitchen?",
    "lights in den": "no device is in 'den'; did you mean deny?",
    "area=kitchen-ette or in 'deny x'": "no device is in 'deny x'; did you mean deny?",
    "lights not in kitchne": "no device is in 'kitchne'; did you mean kitchen?",
    "dimable": "no device has the word 'dimable'; did you mean dimmable?",
    "ligths": "no device has the word 'ligths'; did you mean lights?",
    "plug or vavle": "no device has the word 'vavle'; did you mean valve?",
    "light naer rosie": "no device has the word 'naer'; did you mean near?",
    "gateway=mqt": "",
    "gateway=mqttt": "no device is reached through 'mqttt'; did you mean mqtt?",
    "convention=homeasistant": "no device was announced by 'homeasistant'; did you mean homeassistant?",
}


@pytest.mark.parametrize(("text", "problem"), REFUSED.items(), ids=REFUSED)
def test_a_misspelt_word_is_named_with_what_was_meant(house: DeviceIndex, text: str, problem: str) -> None:
    """Words of three letters and less have no typos, only other words."""
    assert refusal(house, text).startswith(problem)
    assert bool(problem) == bool(refusal(house, text))


@pytest.mark.parametrize(
    "text", ["in bathroom", "robot", "hall", "desk", "dexk", "gateway=zigbee", "type=plug", "hall_button"]
)
def test_what_may_be_there_tomorrow_is_no_mistake(house: DeviceIndex, text: str) -> None:
    assert refusal(house, text) == ""
