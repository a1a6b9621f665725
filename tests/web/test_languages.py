"""The table of the page's languages: complete, for its own texts and for the words of the vocabulary."""

import json
import re
from pathlib import Path

import pytest
from tests.web.told_messages import told_messages

from homebot.control.leases import LEASE_POLICY
from homebot.control.policies import interlock, presence_guard, quiet_hours, rate_limit
from homebot.control.policies.rights import ALWAYS_ASK, APPROVAL, GRANTS
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.client_rights import ASK, CLIENT_RIGHTS, HARMLESS
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.findings import FindingKind
from homebot.devices.outcomes import OUTCOMES
from homebot.devices.wording.values import flag_texts

SOURCE = Path(__file__).parents[2] / "src/homebot/web/source"
PAGE, TOLD, REASONS = (
    dict[str, list[str]](json.loads((SOURCE / f"{name}.json").read_text())) for name in ("languages", "told", "reasons")
)
TABLE = PAGE | TOLD | REASONS
FEATURES = SOURCE.parents[1] / "features"
TEXTS = "\n".join(one.read_text() for one in (*SOURCE.rglob("*.js"), *FEATURES.rglob("page/*.js")))
SAID = re.compile(r'say\((?:[^?()]*\? "([^"]+)" : )?"([^"]+)"')
LABELS = re.compile(r"(?:aria-label|title|placeholder)=(?:\"([^\"]*)\"|\$\{`([^`]*)`\})")
PYTHON = "\n".join(one.read_text() for one in SOURCE.parents[1].rglob("*.py"))
COUNTERS = re.compile(
    r'(\w+): int = (?:fault|loss)\(\)|Count\(name="(\w+)"[^)]*severity|Count\.each\(\{"(\w+)": [^}]*\}, S'
)
FIELD = re.compile(r"\{\w+\}")
SPEAKERS = pytest.mark.rooms(
    *("alerts", "habits", "history", "homekit_bridge", "identify", "page", "recording", "routines", "scenes"),
    *("homeassistant", "homekit", "hue", "matter", "things", "tasmota", "valetudo", "zigbee2mqtt"),
)
"""Whose reasons and counters the page translates."""


WRITTEN = {"on_off": "on/off", "pm1": "PM1", "pm10": "PM10", "pm25": "PM2.5"}


def spoken(name: str) -> str:
    return WRITTEN[name] if name in WRITTEN else name.removeprefix("x_").replace("_", " ")


def test_a_text_has_five_translations_with_the_same_fields() -> None:
    fields = {english: [set(FIELD.findall(one)) for one in found if one.strip()] for english, found in TABLE.items()}
    assert [english for english, found in fields.items() if found != [set(FIELD.findall(english))] * 5] == []


def test_a_text_stands_in_one_table() -> None:
    assert len(TABLE) == len(PAGE) + len(TOLD) + len(REASONS)


def test_every_text_of_the_page_is_translated() -> None:
    said = {text for found in SAID.findall(TEXTS) for text in found if text}
    assert len(said) > 100
    assert said - TABLE.keys() == set()


@SPEAKERS
def test_what_the_doctor_finds_is_translated() -> None:
    """Titles, next steps, and the counters that should be 0."""
    forms = {re.sub(r"\{\w+\}", "{}", one) for one in TABLE}
    texts = {text for kind in FindingKind for text in (kind.title, kind.next_step) if text}
    counters = {spoken(name) for found in COUNTERS.findall(PYTHON) for name in found if name}
    assert {"commands refused", "journal failures", "news missed"} <= counters
    assert (texts | counters) - forms == set()


def test_a_label_for_a_screen_reader_has_no_words_of_its_own() -> None:
    """Such as that of a plot."""
    labels = [re.sub(r"\$\{[^}]*\}", "", first + second) for first, second in LABELS.findall(TEXTS)]
    assert labels
    assert [one for one in labels if re.search("[A-Za-z]", one)] == []


def test_device_types_states_and_capabilities_are_translated() -> None:
    known = CAPABILITIES.items()
    words = {spoken(one) for one in (*DEVICE_TYPES, *CAPABILITIES)}
    words |= {
        word for name, one in known if one.kind == "bool" and "press" not in one.words for word in flag_texts(name)
    }
    words |= {spoken(option) for _, one in known for option in one.options}
    assert words - TABLE.keys() == set()


def test_every_outcome_has_a_text_in_other_languages() -> None:
    (table,) = re.findall(r"const OUTCOMES = \{\n(.*?)\};", TEXTS, re.DOTALL)
    found = dict(re.findall(r'(\w+): "([^"]+)"', table))
    assert found.keys() == OUTCOMES.keys()
    assert set(found.values()) <= TABLE.keys()


def test_the_policies_are_translated() -> None:
    own = (one.NAME for one in (interlock, presence_guard, quiet_hours, rate_limit))
    rights = (CLIENT_RIGHTS, GRANTS, HARMLESS, ALWAYS_ASK, APPROVAL, ASK)
    assert {spoken(one) for one in (*own, *rights, LEASE_POLICY)} - TABLE.keys() == set()


@SPEAKERS
@pytest.mark.parametrize("reason", REASONS)
def test_a_reason_that_is_translated_is_one_that_homebot_gives(reason: str) -> None:
    """Its words are in the source, between the fields, or in a message that the source puts together."""
    words = [one.strip(" ,") for one in re.split(r"\{\w+\}|:| at |, and ", reason)]
    unknown = [one for one in words if one not in PYTHON]
    assert [one for one in unknown if not any(one in message for message in told_messages())] == []
