import pytest

from homebot.conventions.homeassistant.appliances import build_lawn_mower
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

MOWER = {
    "activity_state_topic": "mower/state",
    "activity_value_template": "{{ value_json.activity }}",
    "start_mowing_command_topic": "mower/start",
    "start_mowing_command_template": '{"do": "{{ value }}"}',
    "dock_command_topic": "mower/dock",
}
PART = build_lawn_mower(DiscoveryConfig("lawn_mower", "node_1", MOWER))


@pytest.mark.parametrize(
    ("said", "state"), [("mowing", "mowing"), ("returning", "returning"), ("error", "error"), ("none", None)]
)
def test_it_says_what_it_does(said: str, state: PlainValue) -> None:
    payload = f'{{"activity": "{said}"}}'.encode()
    assert PART.codec.read("mower/state", payload, retained=True) == {"mower": state}


def test_what_is_no_activity_changes_nothing() -> None:
    assert PART.codec.read("mower/state", b'{"activity": "dancing"}', retained=True) == {}


@pytest.mark.parametrize(
    ("word", "topic", "payload"),
    [("mowing", "mower/start", b'{"do": "start_mowing"}'), ("docked", "mower/dock", b"dock")],
)
def test_each_command_has_its_topic(word: str, topic: str, payload: bytes) -> None:
    (publication,) = PART.codec.write("mower", word)
    assert (publication.topic, publication.payload) == (topic, payload)


def test_a_command_without_a_topic_is_refused() -> None:
    with pytest.raises(RefusedError, match="mowing, docked"):
        PART.codec.write("mower", "paused")


def test_it_names_where_it_listens() -> None:
    assert PART.part.writes == ("mower/start", "mower/dock")


def test_it_names_the_words_that_it_takes() -> None:
    assert [one.options for one in PART.part.capabilities] == [("mowing", "docked")]
