"""Plain words: what parts say, and what they are told."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.devices.names import is_text_address, read_text_address, text_address
from homebot.devices.part import Capability, Part, accepted_values, check_setting
from homebot.devices.text.commands import decode_command, encode_command, main_part
from homebot.devices.text.states import decode_text, encode_state
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError


def part(*settable: str, **options: tuple[str, ...]) -> Part:
    names = (*settable, *options)
    return Part(
        id="",
        service_type="light",
        capabilities=tuple(Capability(name=one, settable=True, options=options.get(one, ())) for one in names),
    )


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        ({"level": 40.0, "on_off": True, "color_temperature": 2700.0}, "on"),
        ({"on_off": False, "level": 0.0}, "off"),
        ({"level": 40.0}, "0.4"),
        ({"color_temperature": 2700.0}, "2700 K"),
        ({"position": 0.0}, "closed"),
        ({"position": 100.0, "movement": "open"}, "open"),
        ({"position": 30.0, "movement": "stopped"}, "0.3"),
        ({"position": 30.0, "movement": "closing"}, "closing"),
        ({"movement": "open"}, "open"),
        ({"lock": "jammed"}, "jammed"),
        ({"contact": True}, "open"),
        ({"contact": False, "battery": 80.0}, "closed"),
        ({"occupancy": True, "illuminance": 3.0}, "motion"),
        ({"occupancy": False}, "clear"),
        ({"temperature": 21.5}, "21.5"),
        ({"temperature": -0.0001}, "0"),
        ({"smoke": True}, "on"),
        ({"on_off": None, "temperature": 3.0}, "3"),
        ({"on_off": None}, None),
        ({"color": (1.0, 2.0)}, None),
        ({}, None),
    ],
)
def test_a_message_is_told_in_one_word(readings: dict[str, PlainValue], said: str | None) -> None:
    assert encode_state(readings) == said


@pytest.mark.parametrize(
    ("said", "thing", "meant"),
    [
        ("off", part("level", "on_off"), ("on_off", False)),
        ("close", part("tilt"), ("tilt", 0.0)),
        ("open", part("tilt", "position"), ("position", 100.0)),
        ("0.4", part("on_off", "level"), ("level", 40.0)),
        ("0", part("on_off", "level"), ("on_off", False)),
        ("2700 K", part("color_temperature"), ("color_temperature", 2700.0)),
        ("open", part("movement", "position"), ("movement", "open")),
        ("close", part("position"), ("position", 0.0)),
        ("0.5", part("movement", "position"), ("position", 50.0)),
        ("stop", part("valve"), ("valve", "stopped")),
        ("unlock", part("lock"), ("lock", "unlocked")),
        ("21.5", part("heating_setpoint"), ("heating_setpoint", 21.5)),
        ("press", part("push"), ("push", True)),
        ("eco", part("on_off", preset_mode=("eco", "away")), ("preset_mode", "eco")),
        ("off", part("fan_speed"), ("fan_speed", 0.0)),
        ("off", part(fan_mode=("OFF", "LOW")), ("fan_mode", "OFF")),
        ("off", part("on_off", fan_mode=("OFF", "LOW")), ("on_off", False)),
        ("anything", part("text"), ("text", "anything")),
    ],
)
def test_a_text_is_decoded_by_the_capabilities_of_the_part(
    said: str, thing: Part, meant: tuple[str, PlainValue]
) -> None:
    assert decode_command(said, thing) == meant


@pytest.mark.parametrize("said", ["on", "1.5", "nan", "", "3 K", "eco"])
def test_a_word_that_the_part_does_not_take_is_refused_with_those_that_it_takes(said: str) -> None:
    with pytest.raises(
        RefusedError, match=r"this part takes open, close, stop, a number from 0 to 1 \(0.4 for 40 %\)$"
    ):
        decode_command(said, part("movement", "position"))


def test_a_part_that_cannot_be_told_anything_takes_nothing() -> None:
    sensor = Part(id="", service_type="temperature_sensor", capabilities=(Capability(name="temperature"),))
    with pytest.raises(RefusedError, match="takes no commands"):
        decode_command("on", sensor)


def test_the_main_part_is_no_setting_and_no_diagnosis() -> None:
    lamp = Part(id="lamp", service_type="light")
    led = Part(id="led", service_type="switch", category="config")
    assert main_part((led, lamp)) is lamp
    assert main_part((led,)) is led
    assert main_part(()) is None


@given(st.text(), st.text())
def test_a_words_address_holds_key_and_part(key: str, part_id: str) -> None:
    address = text_address(key, part_id)
    assert read_text_address(address) == (key, part_id)
    assert is_text_address(address)


@pytest.mark.parametrize("address", ["home/lamp/out", "words:x", "words:a#b#c", ""])
def test_any_other_address_is_none(address: str) -> None:
    assert read_text_address(address) is None
    assert not is_text_address(address)


@given(st.dictionaries(st.text(), st.none() | st.booleans() | st.floats() | st.text() | st.tuples(st.floats())))
def test_no_reading_is_too_odd_for_a_word(readings: dict[str, PlainValue]) -> None:
    said = encode_state(readings)
    assert said is None or isinstance(said, str)


@given(st.text(), st.sampled_from(["level", "position", "on_off", "text", "option", "color_temperature"]))
def test_no_word_is_too_odd_to_be_judged(said: str, name: str) -> None:
    decode_text(said, part(name))
    try:
        capability, _ = decode_command(said, part(name))
    except RefusedError:
        return
    assert capability == name


LIGHT = part("on_off", "level", "color_temperature")
OPENING = part("movement", "position")


@pytest.mark.parametrize(
    ("said", "thing", "told_of_it"),
    [
        ("on", LIGHT, {"on_off": True}),
        ("0.4", LIGHT, {"level": 40.0, "on_off": True}),
        ("0.07", LIGHT, {"level": 7.0, "on_off": True}),
        ("0", LIGHT, {"level": 0.0, "on_off": False}),
        ("2700 K", LIGHT, {"color_temperature": 2700.0}),
        ("closing", OPENING, {"movement": "closing"}),
        ("closed", OPENING, {"movement": "closed", "position": 0.0}),
        ("0.3", OPENING, {"position": 30.0, "movement": "stopped"}),
        ("1", OPENING, {"position": 100.0, "movement": "open"}),
        ("open", part("valve"), {"valve": "open"}),
        ("jammed", part("lock"), {"lock": "jammed"}),
        ("open", part("contact"), {"contact": True}),
        ("clear", part("occupancy"), {"occupancy": False}),
        ("-3.5", part("temperature"), {"temperature": -3.5}),
        ("20.5", part("heating_setpoint", "local_temperature"), {"local_temperature": 20.5}),
        ("kitchen", part("value"), {"value": "kitchen"}),
        ("eco", part("on_off", preset_mode=("eco", "away")), {"preset_mode": "eco"}),
    ],
)
def test_a_text_gives_a_value_and_the_implied_ones(said: str, thing: Part, told_of_it: dict[str, PlainValue]) -> None:
    assert decode_text(said, thing) == told_of_it


@pytest.mark.parametrize("said", ["", "ON", "1.5", "-0.1", "nan", "inf", "2700", "3 K", "open", "on off", "1e999"])
def test_an_unknown_text_of_a_lamp_gives_no_value(said: str) -> None:
    assert decode_text(said, LIGHT) == {}


def test_a_part_reports_no_unreadable_capability() -> None:
    mute = Part(id="", service_type="plug", capabilities=(Capability(name="on_off", readable=False, settable=True),))
    assert decode_text("on", mute) == {}


_percents = st.integers(0, 1000).map(lambda share: share / 10)
_movements = st.sampled_from(["open", "closed", "opening", "closing", "stopped"])


@given(
    st.one_of(
        st.tuples(st.just(LIGHT), st.fixed_dictionaries({}, optional={"on_off": st.booleans()})),
        st.tuples(st.just(LIGHT), st.fixed_dictionaries({"level": _percents})),
        st.tuples(st.just(LIGHT), st.fixed_dictionaries({"color_temperature": st.integers(1000, 9000).map(float)})),
        st.tuples(st.just(OPENING), st.fixed_dictionaries({"position": _percents})),
        st.tuples(st.just(OPENING), st.fixed_dictionaries({"movement": _movements})),
        st.tuples(st.just(part("lock")), st.fixed_dictionaries({"lock": st.sampled_from(["locked", "jammed"])})),
        st.tuples(st.just(part("contact")), st.fixed_dictionaries({"contact": st.booleans()})),
        st.tuples(st.just(part("power")), st.fixed_dictionaries({"power": st.integers(-9000, 9000).map(float)})),
    )
)
def test_an_encoded_state_is_decoded_to_the_same_values(case: tuple[Part, dict[str, PlainValue]]) -> None:
    """Of several values those that the word is about."""
    thing, readings = case
    said = encode_state(readings)
    found = {} if said is None else decode_text(said, thing)
    both = found.keys() & readings.keys()
    assert bool(both) == (said is not None)
    assert [found[one] for one in both] == [readings[one] for one in both]


@pytest.mark.parametrize(
    ("capability", "value", "thing", "said"),
    [
        ("on_off", True, LIGHT, "on"),
        ("level", 40.0, LIGHT, "0.4"),
        ("level", 0.0, LIGHT, "0"),
        ("color_temperature", 2700.0, LIGHT, "2700 K"),
        ("movement", "closed", OPENING, "close"),
        ("movement", "stopped", OPENING, "stop"),
        ("position", 100.0, OPENING, "1"),
        ("position", 0.0, part("position"), "close"),
        ("lock", "unlocked", part("lock"), "unlock"),
        ("lock", "open", part("lock"), "open"),
        ("valve", "open", part("valve"), "open"),
        ("heating_setpoint", 21.5, part("heating_setpoint"), "21.5"),
        ("push", True, part("push"), "press"),
        ("text", "anything", part("text"), "anything"),
    ],
)
def test_a_value_is_told_by_the_word_for_it(capability: str, value: PlainValue, thing: Part, said: str) -> None:
    assert encode_command(capability, value, thing) == said


@pytest.mark.parametrize(
    ("capability", "value"),
    [
        ("color", (0.0, 100.0)),
        ("on_off", None),
        ("on_off", 0.0),
        ("on_off", "on"),
        ("level", True),
        ("level", 0.04),
        ("level", 101.0),
        ("level", float("nan")),
        ("color_temperature", 10.0),
        ("movement", "open"),
    ],
)
def test_a_value_without_a_word_is_refused_with_the_words_that_there_are(capability: str, value: PlainValue) -> None:
    with pytest.raises(RefusedError, match=r"this part takes on, off, 2700 K, a number from 0 to 1 \(0.4 for 40 %\)$"):
        encode_command(capability, value, LIGHT)


def test_a_bare_number_sets_the_only_number_of_a_part() -> None:
    assert decode_command("21", part("color_temperature", "temperature")) == ("temperature", 21.0)
    with pytest.raises(RefusedError, match="'21' was refused"):
        decode_command("21", part("humidity", "temperature"))


def test_a_number_that_would_be_taken_for_another_one_is_refused() -> None:
    """A bare number is about the position where there is one."""
    with pytest.raises(RefusedError):
        encode_command("tilt", 50.0, part("position", "tilt"))


_values: st.SearchStrategy[PlainValue] = st.one_of(
    st.none(),
    st.booleans(),
    st.floats(),
    st.floats(0, 100),
    st.text(max_size=5),
    st.sampled_from(["open", "closed", "stopped", "locked", "unlocked", "lock", "close"]),
    st.tuples(st.floats()),
)
_names = st.sampled_from(["on_off", "level", "position", "movement", "lock", "text", "color_temperature", "tilt", "x"])


@given(_names, _values, st.lists(_names, unique=True, max_size=4))
def test_an_encoded_command_is_decoded_to_the_same_value(name: str, value: PlainValue, names: list[str]) -> None:
    """To three digits; what has no word is refused."""
    thing = part(*names)
    try:
        said = encode_command(name, value, thing)
    except RefusedError:
        return
    what, meant = decode_command(said, thing)
    if (name, value) == ("level", 0.0) and what == "on_off":
        assert meant is False
    else:
        assert what == name
        assert meant == (pytest.approx(value, abs=0.1) if isinstance(value, float) else value)


def test_states_that_are_only_reported_are_no_words() -> None:
    """An alarm panel lists its states among its options, as it reports them."""
    panel = part(alarm=("disarmed", "armed_home", "pending", "arming", "disarming", "triggered"))
    with pytest.raises(RefusedError, match=r"this part takes disarmed, armed_home, triggered$"):
        decode_command("pending", panel)
    assert accepted_values(panel, "alarm") == "disarmed, armed_home, triggered"
    with pytest.raises(RefusedError, match="takes disarmed, armed_home, triggered"):
        check_setting("it", panel, "alarm", "arming")
