"""Automations in the shapes that people publish: carried over right, or refused by name.

HOMEBOT_WRITE_GOLDEN=1 writes what is carried over anew, to be read by a person.
"""

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.cli.yaml_loader import load_located
from homebot.devices.device import Device, DevicePart, Endpoint, Fact
from homebot.devices.part import Capability, Part
from homebot.devices.query.terms import NameIs, leaves
from homebot.errors import UsageError
from homebot.features.routines.text import read_routines
from homebot.integrations.homeassistant.automations import HomeAssistantAutomations
from homebot.messages import Time
from homebot.support.folding import fold
from homebot.words.automations import ImportedRoutines
from homebot.words.conditions import Matches, read_condition
from homebot.words.steps import Do, read_step

HERE = Path(__file__).parent
SOURCE = "automations.yaml"
SETTABLE = {
    "on_off", "level", "color", "color_temperature", "movement", "position", "lock", "heating_setpoint",
    "thermostat_mode", "playback", "volume", "vacuum", "alarm", "scene", "fan_speed",
    "option", "number", "text", "media",
}  # fmt: skip
OPTIONS = {
    "press": ("single", "double", "hold", "long", "remote_button_short_press turn_on"),
    "thermostat_mode": ("off", "heat"),
    "option": ("day", "night"),
    "value": ("rainy", "pouring", "sunny", "partlycloudy"),
}
NOW = Time.from_seconds(0.0)


def part(
    part_id: str, kind: str, *names: str, name: str = "", options: Mapping[str, tuple[str, ...]] = OPTIONS
) -> DevicePart:
    bounds = {"heating_setpoint": (5.0, 30.0), "color_temperature": (2000.0, 6500.0)}
    able = tuple(
        Capability(name=one, settable=one in SETTABLE, options=options.get(one, ()), bounds=bounds.get(one, ()))
        for one in names
    )
    return DevicePart(id=part_id, part=Part(id=part_id, service_type=kind, name=name, capabilities=able), routes=())


def device(name: str, *parts: DevicePart, entities: str = "", key: str = "", area: str = "", at: str = "") -> Device:
    endpoint = Endpoint(gateway="homeassistant", key=key or name, address=at, command_address="", freshness="fresh",
                        last_seen=NOW)  # fmt: skip
    facts = (Fact(name="entities", value=entities, gateway="homeassistant", convention="", key=key, said_at=NOW),)
    return Device(
        id=name.lower().replace(" ", "_"), name=name, names=(name,), service_type=parts[0].part.service_type,
        endpoints=(endpoint,), metadata=(), first_seen=NOW, last_seen=NOW, expires=NOW, freshness="fresh",
        parts=parts, area=area, facts=facts if entities else (),
    )  # fmt: skip


HELPERS = Endpoint(gateway="helpers", key="", address="", command_address="", freshness="fresh", last_seen=NOW)
LAMP = ("on_off", "level", "color", "color_temperature")
HOUSE = (
    device("Hall lamp", part("", "light", *LAMP), area="Hall", at="zigbee2mqtt/hall_lamp"),
    device("Floor lamp", part("", "light", "on_off"), area="Living room"),
    device("Hall motion", part("", "occupancy_sensor", "occupancy", "illuminance", "battery", "tamper"), area="Hall"),
    device("Stairs motion", part("", "occupancy_sensor", "occupancy")),
    device("Bath window", part("", "contact_sensor", "contact", "battery")),
    device("Front door", part("", "contact_sensor", "contact", "battery_low")),
    device("Front door lock", part("", "door_lock", "lock"), entities="lock.front_door"),
    device("Bath heating", part("", "thermostat", "heating_setpoint", "local_temperature", "thermostat_mode")),
    device("Washer", part("", "plug", "on_off"), part("m", "electrical_meter", "power", "energy")),
    device("Stove", part("", "electrical_meter", "power"), entities="sensor.oven_power (kW)"),
    device("Kitchen plug", part("", "plug", "on_off")),
    device("Double relay", part("l", "switch", "on_off", name="left"), part("r", "switch", "on_off", name="right")),
    device("Living blind", part("", "window_covering", "movement", "position"), area="Living room"),
    device("Kitchen radio", part("", "speaker", "on_off", "volume", "playback", "media")),
    device("Weather", part("", "x_sensor", "value", "temperature"), entities="weather.home"),
    device("Phone alarm", part("", "x_sensor", "value", options={}), entities="sensor.phone_next_alarm"),
    device("Hall button", part("", "generic_switch", "press"), key="dev-button"),
    device("Remote", part("", "generic_switch", "press"), key="dev-remote"),
    device("Wall dimmer", part("", "generic_switch", "press"), at="zigbee2mqtt/wall_dimmer"),
    device("Bell", part("", "generic_switch", "press"), entities="event.doorbell"),
    device("Movie", part("", "x_scene", "scene"), entities="scene.movie"),
    device("Anna", part("", "x_tracker", "place"), entities="person.anna"),
    device("House alarm", part("", "x_alarm_panel", "alarm"), entities="alarm_control_panel.house"),
    device("Rosie", part("", "robotic_vacuum_cleaner", "vacuum")),
    device("Phone", part("", "x_tracker", "place"), entities="device_tracker.phone"),
    device("Bath climate", part("", "temperature_sensor", "temperature", "humidity")),
    device("Bath fan", part("", "fan", "on_off", "fan_speed")),
    device("Bath leak", part("", "water_leak_detector", "water_leak")),
    *(
        device(name, part("", "x_setting", *able)).model_copy(update={"endpoints": (HELPERS,)})
        for name, able in {
            "vacation": ["on_off"],
            "lux limit": ["number"],
            "mode": ["option"],
            "visits": ["number"],
            "oven": ["on_off", "press", "number"],
            "wake up": ["text"],
            "good night": ["press", "push"],
            "stop radio": ["press", "push"],
            "keep heat": ["press", "push"],
            "close": ["press", "push"],
        }.items()
    ),
    device("Household", part("", "x_household", "at_home", "all_at_home")),
)


def read(text: str, devices: Iterable[Device] = HOUSE) -> ImportedRoutines:
    return HomeAssistantAutomations().read(
        load_located(text), SOURCE, tuple(devices), lambda text, origin: read_routines(text, origin)[0]
    )


@pytest.fixture(
    scope="module",
    params=[
        "automations",
        "forum",
        "asked",
        "unseen",
        "posts",
        "kinds",
        "lasting",
        "answers",
        "fresh",
        "players",
        "moments",
    ],
)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def found(name: str) -> ImportedRoutines:
    return read((HERE / f"{name}.yaml").read_text("utf-8"))


def golden(name: str, shown: str) -> str:
    """Return what the file *name* has."""
    path = HERE / name
    if os.environ.get("HOMEBOT_WRITE_GOLDEN"):
        path.write_text(shown, "utf-8")
    return path.read_text("utf-8")


def test_what_is_carried_over_means_the_same(name: str, found: ImportedRoutines) -> None:
    """The files were compared with the automations by hand."""
    assert "\n".join(found.texts) == golden(f"{name}.toml", "\n".join(found.texts))


def test_what_is_not_carried_over_is_named_with_its_line_and_reason(name: str, found: ImportedRoutines) -> None:
    shown = "".join(f"{one.line}: {one.name}: {one.problem}\n" for one in sorted(found.refused))
    assert shown == golden(f"{name}.refused.txt", shown)


def test_each_automation_is_carried_over_or_refused_and_none_both(name: str, found: ImportedRoutines) -> None:
    """None is carried over in half."""
    refused = {one.name for one in found.refused}
    carried = {one.name.partition(" (")[0] for one in read_routines("\n".join(found.texts), SOURCE)}
    twice = {"Hall light by motion"} if name == "automations" else set()
    assert refused & carried == twice, "the second one of this name is refused"
    assert len(refused | carried) + len(twice) == found.total


@pytest.mark.parametrize(
    ("asked", "people", "texts"),
    [
        ("<= 1", 2, ['if = ["not everybody is home"]']),
        (">= 2", 2, ['if = ["everybody is home"]']),
        ("<= 1", 3, []),
        (">= 0", 0, []),
        ("< 0", 0, []),
    ],
)
def test_people_at_home_are_counted_as_far_as_none_any_and_all(asked: str, people: int, texts: list[str]) -> None:
    found = read(
        f"""
- alias: A
  trigger: {{platform: time, at: '08:00'}}
  condition: "{{{{ states('zone.home') | int(0) {asked} }}}}"
  action: {{service: light.turn_on, entity_id: light.hall_lamp}}
""",
        (*HOUSE, *(device(f"Person {number}", part("", "x_person", "at_home")) for number in range(people))),
    )
    assert [line for text in found.texts for line in text.splitlines() if line.startswith("if =")] == texts
    assert len(found.texts) == len(texts)


@pytest.mark.parametrize("variables", ["{a: '{{ a }}'}", "{a: '{{ b }}', b: '{{ a }}'}"])
def test_variables_that_name_each_other_are_refused(variables: str) -> None:
    found = read(f"""
- alias: A
  trigger: {{platform: time, at: '08:00'}}
  action:
    - variables: {variables}
    - choose: [{{conditions: "{{{{ a == 'x' }}}}", sequence: [{{service: light.turn_on, entity_id: light.hall_lamp}}]}}]
""")
    assert not found.texts
    assert "template 'a'" in found.refused[0].problem


KEYS = (
    "alias",
    "trigger",
    "platform",
    "condition",
    "action",
    "service",
    "entity_id",
    "to",
    "for",
    "choose",
    "if",
    "data",
)
VALUES = ("state", "on", "light.hall_lamp", "light.turn_on", "name='x", "{{ x }}", "00:05:00", "and", "trigger", "or")


@given(
    st.recursive(
        st.sampled_from(VALUES) | st.integers() | st.booleans() | st.none(),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS), inner, max_size=5),
        max_leaves=30,
    )
)
def test_any_document_is_read_or_refused(document: object) -> None:
    """What is carried over can be read by homebot."""
    try:
        found = read(json.dumps(document))
    except UsageError:
        return
    assert found.total == len(found.texts) or found.refused
    for one in found.texts:
        read_routines(one, SOURCE)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("Anna's lamp", "Anna's lamp"),
        ("Turn on off", "Turn on off"),
        ("Lamp in hall below 5", "the/id"),
        ("Lamp for 5m", "the/id"),
        ('Lamp "two", on', "the/id"),
        ("press press", "the/id"),
        ("a: b", "the/id"),
    ],
)
def test_strange_names_are_written_so_that_homebot_reads_them_again(name: str, meant: str) -> None:
    lamp = device(name, part("", "light", "on_off"), entities="light.a").model_copy(update={"id": "the/id"})
    text = """
- alias: A
  trigger: {platform: time, at: '12:00'}
  condition: {condition: state, entity_id: light.a, state: 'on'}
  action: {service: light.turn_off, entity_id: light.a}
"""
    found = read(text, [lamp])
    assert not found.refused
    (routine,) = read_routines(found.texts[0], SOURCE)
    (condition,) = map(read_condition, cast("list[str]", routine.table["if"]))
    assert isinstance(condition, Matches)
    assert next(leaves(condition.state.query)) == NameIs(fold(meant))
    (step,) = map(read_step, cast("list[str]", routine.table["do"]))
    assert isinstance(step, Do)
    assert (step.target, step.command) == (meant, "off")


def test_a_plug_of_the_same_name_is_not_the_player() -> None:
    """Nor is a switch the helper that is called like it."""
    text = """
- {trigger: {platform: sun, event: sunset}, action: {service: media_player.turn_off, entity_id: media_player.tv}}
- {trigger: {platform: sun, event: sunset}, action: {service: input_boolean.turn_on, entity_id: input_boolean.tv}}
"""
    found = read(text, [device("TV", part("", "plug", "on_off"))])
    assert [one.problem for one in found.refused] == [
        "media_player.tv is nothing that homebot knows",
        "input_boolean.tv is nothing that homebot knows; a device has the name of this helper: give it another one",
    ]


@pytest.mark.parametrize(
    ("entity", "type_", "state"),
    [
        ("cover.living_blind", "is_open", "open"),
        ("cover.living_blind", "is_closed", "closed"),
        ("lock.front_door", "is_locked", "locked"),
    ],
)
def test_a_state_of_a_device_means_that_of_its_entity(entity: str, type_: str, state: str) -> None:
    """The form of Home Assistant asks so for a garage door or a lock."""
    action = "{service: light.turn_on, entity_id: light.hall_lamp}"
    head = "- {trigger: {platform: sun, event: sunset}, condition: "
    own = f"{{condition: device, device_id: x, domain: {entity.partition('.')[0]}, entity_id: {entity}, type: {type_}}}"
    (found,) = read(f"{head}{own}, action: {action}}}").texts
    (same,) = read(f"{head}{{condition: state, entity_id: {entity}, state: {state}}}, action: {action}}}").texts
    assert found == same


def test_two_devices_of_one_name_are_told_apart_by_their_ids() -> None:
    lamps = [device("Lamp", part("", "light", "on_off"), entities=f"light.{one}") for one in "ab"]
    lamps = [one.model_copy(update={"id": f"lights/{number}"}) for number, one in enumerate(lamps)]
    text = "- {trigger: {platform: time, at: '9:00'}, action: {service: light.turn_on, entity_id: light.b}}"
    (found,) = read(text, lamps).texts
    assert 'do = ["lights/1 on"]' in found


def test_an_id_that_reads_like_a_name_of_two_is_asked_as_an_id() -> None:
    """A lamp and a player that is on are often called after their room."""
    rooms = [
        device("Bedroom", part("", "light", *LAMP), entities="light.bedroom"),
        device("Bedroom", part("", "speaker", "on_off", "volume")).model_copy(update={"id": "bedroom_2"}),
    ]
    (found,) = read(
        """
- alias: A
  trigger: {platform: time, at: '9:00'}
  condition: {condition: state, entity_id: light.bedroom, state: 'on'}
  action:
    - service: light.turn_on
      entity_id: light.bedroom
      data: {brightness_pct: "{{ state_attr('light.bedroom', 'brightness') | float(0) / 5 }}"}
    - {wait_template: "{{ is_state('light.bedroom', 'off') }}", timeout: 60}
""",
        rooms,
    ).texts
    assert "if = [\"id='bedroom' on\"]" in found
    assert "default(level of id='bedroom' / 0.392" in found
    assert "wait until id='bedroom' off, at most 1m" in found


def test_a_name_that_two_devices_may_have_made_is_refused() -> None:
    lamps = [device(name, part("", "light", "on_off")).model_copy(update={"id": name}) for name in ("A b", "A-b")]
    found = read(
        "- {trigger: {platform: sun, event: sunset}, action: {service: light.turn_on, entity_id: light.a_b}}", lamps
    )
    assert [one.problem for one in found.refused] == ["light.a_b may be several parts of what homebot knows"]


@pytest.mark.parametrize(("mode", "is_asked_before"), [("single", True), ("restart", False), ("queued", False)])
def test_actions_that_begin_with_a_condition_end_or_await_the_run_before(mode: str, *, is_asked_before: bool) -> None:
    text = f"""
- mode: {mode}
  trigger: {{platform: time, at: '12:00'}}
  action:
    - {{condition: state, entity_id: light.hall_lamp, state: 'off'}}
    - {{service: light.turn_on, entity_id: light.hall_lamp}}
    - {{delay: 60}}
"""
    (routine,) = read_routines(read(text).texts[0], SOURCE)
    assert ("if" in routine.table) is is_asked_before
    assert isinstance(cast("list[object]", routine.table["do"])[0], dict) is not is_asked_before


def test_triggers_of_one_text_with_two_ids_are_refused() -> None:
    text = """
- alias: A
  trigger:
    - {platform: time, at: '8:00', id: begin}
    - {platform: time, at: '8:00', id: end}
  action:
    - if: [{condition: trigger, id: end}]
      then: [{service: light.turn_off, entity_id: light.hall_lamp}]
"""
    assert [one.problem for one in read(text).refused] == ["two triggers are the same for a routine: 8:00"]


@pytest.mark.parametrize(
    ("trigger", "data", "problem"),
    [
        ("trigger: time, at: '7:00'", "color_temp: 0", "color_temperature from"),
        ("trigger: time, at: '7:00'", "brightness: .nan", "brightness: nan is not a number"),
        ("trigger: time, at: '7:00'", "transition: .inf", "transition: inf is not a number"),
        ("trigger: state, entity_id: light.floor_lamp, to: 'on', for: 5:00", "", "'5:00' may be minutes or hours"),
        ("trigger: sun, event: sunset, offset: '-1:30'", "", "'-1:30' may be minutes or hours"),
        ("trigger: state, entity_id: media_player.kitchen_radio, to: 'on'", "", "knows no state 'on'"),
    ],
)
def test_what_has_two_meanings_or_none_is_refused(trigger: str, data: str, problem: str) -> None:
    """YAML 1.1 reads 5:00 as 300; a player that plays is not ``on`` in Home Assistant, and is in homebot."""
    target = "target: {entity_id: light.hall_lamp}"
    action = f"{{action: light.turn_on, {target}, data: {{{data}}}}}"
    text = f"- alias: A\n  triggers: [{{{trigger}}}]\n  actions: [{action}]"
    found = read(text)
    assert not found.texts
    assert problem in found.refused[0].problem


def test_automations_in_other_files_are_named_beside_those_that_are_here() -> None:
    text = """
automation ui: !include automations.yaml
automation more: !include_dir_merge_list automations/
automation:
  - {alias: A, trigger: {platform: time, at: '12:00'}, action: {service: light.turn_on, entity_id: light.hall_lamp}}
"""
    found = read(text)
    assert [(one.line, one.problem.partition(":")[0]) for one in found.refused] == [
        (2, "!include 'automations.yaml'"),
        (3, "!include_dir_merge_list 'automations/'"),
    ]
    assert len(found.texts) == 1


@pytest.mark.parametrize(
    ("trigger", "condition", "action", "problem"),
    [
        ("triggers: [{trigger: sun, event: sunset}]", "light.hall_lamp: 'on'", "delay: 5", "trigger: `triggers`"),
        ("trigger: sun, event: sunset", "light.hall_lamp: 'on'", "delay: 5", "condition: `light.hall_lamp`"),
        ("trigger: sun, event: sunset", "condition: sun, after: sunset", "call: light.turn_on", "action: `call`"),
    ],
)
def test_what_is_of_no_kind_is_refused_by_its_first_field(
    trigger: str, condition: str, action: str, problem: str
) -> None:
    found = read(f"- {{triggers: {{{trigger}}}, conditions: {{{condition}}}, actions: {{{action}}}}}")
    assert f"{problem} has no counterpart in routines" in [one.problem for one in found.refused]


@pytest.mark.parametrize(
    ("count", "depth", "problem"),
    [
        ("7", 2, ""),
        ("40", 4, "all rounds"),
        ("101", 1, "100 is the limit"),
        ("9" * 5000, 1, "rounds"),
    ],
)
def test_repeats_in_repeats_are_loops_with_a_limit(count: str, depth: int, problem: str) -> None:
    """Four of 40 would be 2,560,000 steps."""
    action = "{action: light.toggle, target: {entity_id: light.hall_lamp}}"
    for _ in range(depth):
        action = f"{{repeat: {{count: '{count}', sequence: [{action}]}}}}"
    found = read(f"- {{alias: A, triggers: [{{trigger: time, at: '7:00'}}], actions: [{action}]}}")
    assert problem in "".join(one.problem for one in found.refused)
    assert bool(found.refused) is bool(problem)


@pytest.mark.parametrize(("between", "is_carried"), [("", True), ("{delay: '00:01:00'}", False)])
def test_a_variable_is_known_in_rounds_that_follow_at_once(between: str, *, is_carried: bool) -> None:
    """After a wait the sun is elsewhere, and the variable still tells where it was."""
    text = f"""
- trigger: {{platform: sun, event: sunset}}
  action:
    - variables: {{k: "{{{{ 4000 + state_attr('sun.sun', 'elevation') | float(0) * 80 }}}}"}}
    - repeat:
        for_each: [light.hall_lamp, light.floor_lamp]
        sequence:
          - service: light.turn_on
            target: {{entity_id: "{{{{ repeat.item }}}}"}}
            data: {{color_temp_kelvin: "{{{{ k }}}}"}}
          {f"- {between}" if between else ""}
"""
    assert ["4000 + sun elevation * 80" in one for one in read(text).texts] == ([True] if is_carried else [])


@pytest.mark.parametrize(("count", "is_carried"), [(3, True), (6, False)])
def test_choices_in_one_calculation_have_a_limit(count: int, *, is_carried: bool) -> None:
    """Each of them doubles the ways."""
    text = " + ".join(
        f"(1 if is_state('light.floor_lamp', 'on') and now().hour < {hour} else 2)" for hour in range(count)
    )
    found = read(f"""
- alias: A
  trigger: {{platform: time, at: '8:00'}}
  action:
    service: light.turn_on
    entity_id: light.hall_lamp
    data: {{brightness_pct: "{{{{ {text} }}}}"}}
""")
    assert bool(found.texts) is is_carried


@pytest.mark.parametrize(("mode", "count", "carried"), [("queued", 2, 0), ("parallel", 2, 2), ("queued", 1, 1)])
def test_a_script_that_waits_is_carried_over_unless_several_would_run_it_in_turn(
    mode: str, count: int, carried: int
) -> None:
    """Home Assistant has one run after the other; each routine has steps of its own."""
    automations = "".join(
        f"  - {{alias: A{number}, trigger: {{platform: time, at: '{number}:00'}}, action: {{service: script.blink}}}}\n"
        for number in range(1, count + 1)
    )
    lamp = "{service: light.toggle, entity_id: light.hall_lamp}"
    found = read(
        f"automation:\n{automations}script:\n  blink: {{mode: {mode}, sequence: [{lamp}, {{delay: 5}}, {lamp}]}}"
    )
    assert len(found.texts) == carried
    assert all("call it by one" in refusal.problem for refusal in found.refused)
