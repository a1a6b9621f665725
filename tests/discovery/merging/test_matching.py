"""Which parts of different sources are one, whoever comes first."""

from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.announcements import sighting_of
from tests.call_counts import calls
from tests.discovery.announcements import announce, contents

from homebot.devices import Device, Sighting
from homebot.devices.always_ask import why_device_asks
from homebot.devices.part import Capability, Category, Part
from homebot.discovery import DeviceIndex
from homebot.discovery.merging.matching import candidates, match

IEEE = "eui64:00158d0001abcdef"
FOREIGN = (IEEE, "id:zigbee2mqtt_0x17")
STATE, SET = "zigbee2mqtt/motor", "zigbee2mqtt/motor/set"


def made(
    part_id: str,
    service_type: str,
    *names: str,
    name: str = "",
    category: Category = "",
    writes: str = "",
    reads: str = STATE,
    advertised: str = "",
    options: tuple[str, ...] = (),
) -> Part:
    return Part(
        id=part_id,
        name=name,
        service_type=service_type,
        category=category,
        advertised=advertised,
        capabilities=tuple(Capability(name=one, settable=bool(writes), options=options) for one in names),
        reads=(reads,) if reads else (),
        writes=(writes,) if writes else (),
    )


def foreign(object_id: str, component: str, service_type: str, *names: str, **more: object) -> Part:
    """As Zigbee2MQTT announces it to Home Assistant."""
    found: Part = made(
        f"0x17_{object_id}_zigbee2mqtt",
        service_type,
        *names,
        advertised=component,
        **{"writes": f"{SET}/{object_id.removeprefix('switch_')}", **more},  # type: ignore[arg-type]
    )
    return found


def setting(part_id: str, *names: str, **more: object) -> Part:
    found: Part = made(part_id, "x_setting", *names, **{"category": "config", "writes": SET, **more})  # type: ignore[arg-type]
    return found


def without_topics(part_id: str, service_type: str, *names: str) -> Part:
    """As the gateway of a hub describes it."""
    part = made(part_id, service_type, *names, reads="")
    settable = [one.model_copy(update={"settable": True}) for one in part.capabilities]
    return part.model_copy(update={"capabilities": tuple(settable)})


def together(native: tuple[Part, ...], others: tuple[Part, ...]) -> Device:
    """One device of both, the same in every order of (at most four) announcements."""
    sightings = [announce("0x17", *native, convention="zigbee2mqtt", ids=(IEEE,))]
    sightings += [announce(one.id, one, ids=FOREIGN) for one in others]
    found: list[Device] = []
    for order in permutations(sightings):
        index = DeviceIndex(forget_after=1000.0)
        for one in order:
            index.observe(one)
        found += index.devices()
    assert len({contents(one) for one in found}) == 1
    return found[0]


def ways(device: Device) -> set[tuple[str, ...]]:
    return {tuple(way.part for way in one.routes) for one in device.parts}


def test_a_nameless_button_is_not_the_setting_that_it_was_not_told_from() -> None:
    """Two curtain motors of Aqara's: *identify* drove them to their end stops."""
    device = together(
        (
            setting("automatic_calibration", "push", name="Automatic calibration"),
            setting("identify", "locate", name="Identify"),
        ),
        (
            foreign("automatic_calibration", "button", "x_setting", "push", name="Automatic calibration"),
            foreign("identify", "button", "x_setting", "push", "locate", category="config"),
        ),
    )
    assert ways(device) == {
        ("automatic_calibration", "0x17_automatic_calibration_zigbee2mqtt"),
        ("identify", "0x17_identify_zigbee2mqtt"),
    }


def test_a_button_and_a_choice_without_names_do_not_cross() -> None:
    """Where one of the two is missing on one side the other is still not taken for it."""
    own = setting("power_on_behavior", "option", name="Power-on behavior", options=("off", "on"))
    device = together(
        (own, setting("identify", "locate", name="Identify")),
        (foreign("power_on_behavior", "select", "x_setting", "option", category="config", options=("off", "on")),),
    )
    assert ways(device) == {("power_on_behavior", "0x17_power_on_behavior_zigbee2mqtt"), ("identify",)}
    device = together((own,), (foreign("identify", "button", "x_setting", "locate", category="config"),))
    assert ways(device) == {("power_on_behavior",), ("0x17_identify_zigbee2mqtt",)}


def test_who_knows_that_a_switch_is_a_setting_decides_for_both() -> None:
    device = together(
        (made("switch", "switch", "on_off", writes=SET), setting("factory_reset", "on_off", name="Factory reset")),
        (
            foreign("switch", "switch", "switch", "on_off", writes=SET),
            foreign("switch_factory_reset", "switch", "switch", "on_off", name="Factory reset"),
        ),
    )
    assert {(one.part.service_type, one.part.category, len(one.routes)) for one in device.parts} == {
        ("switch", "", 2),
        ("x_setting", "config", 2),
    }


@pytest.mark.parametrize("writes", ["", "evil/set"])
@pytest.mark.parametrize("category", ["", "config"])
@pytest.mark.parametrize("kind", [("closure", "movement"), ("switch", "on_off")])
def test_an_announcement_that_shares_no_topic_with_a_gate_makes_no_setting_of_it(
    kind: tuple[str, str], category: Category, writes: str
) -> None:
    """Nobody has to approve a setting, and any program may command it."""
    gate = announce("gate", made("g", *kind, writes="gate/set"), ids=FOREIGN, name="Gate")
    settable = Capability(name=kind[1], settable=True)
    told = made("g", "x_setting", category=category, writes=writes).model_copy(update={"capabilities": (settable,)})
    evil = announce("evil", told, convention="thing", ids=FOREIGN, name="Gate")
    for order in permutations((gate, evil)):
        index = DeviceIndex(forget_after=1000.0)
        for one in order:
            index.observe(one)
        (device,) = index.devices()
        assert [(one.part.service_type, len(one.routes)) for one in device.parts] == [(kind[0], 2)]
        assert why_device_asks(device)


def test_a_setting_by_the_other_side_alone_is_one_as_well() -> None:
    device = together(
        (made("switch_lock", "switch", "on_off", writes=SET),),
        (setting("0x17_switch_lock_zigbee2mqtt", "on_off"), foreign("temp", "sensor", "x_sensor", "value", writes="")),
    )
    (part,) = [one for one in device.parts if len(one.routes) > 1]
    assert (part.part.service_type, part.part.category) == ("x_setting", "config")


def test_a_load_that_another_calls_a_setting_under_another_id_stays_a_load() -> None:
    device = together(
        (made("state", "switch", "on_off", writes=SET),),
        (foreign("state_lock", "switch", "switch", "on_off", category="config"),),
    )
    assert ways(device) == {("state",), ("0x17_state_lock_zigbee2mqtt",)}


def test_a_load_of_two_gateways_without_topics_is_one_whatever_its_ids_are() -> None:
    """The hub knows colours, and the bridge of another maker does not."""
    own, other = without_topics("light", "light", "on_off", "level", "color"), without_topics("7", "light", "on_off")
    assert match([candidates((own,), ())], candidates((other,), ())) == {0: 0}
    pair = without_topics("8", "light", "on_off")
    assert match([candidates((own,), ())], candidates((other, pair), ())) == {}


def test_what_fits_two_others_equally_well_fits_none() -> None:
    own = [setting(f"delay_{side}", "number", name="Delay") for side in ("left", "right")]
    device = together(tuple(own), (setting("uid", "number", name="Delay", writes=f"{SET}/delay"),))
    assert ways(device) == {("delay_left",), ("delay_right",), ("uid",)}


def test_of_two_ids_that_are_in_a_third_the_whole_one_counts() -> None:
    device = together(
        (setting("delay", "number"), setting("delay_on", "number")),
        (foreign("delay_on", "number", "x_setting", "number"), foreign("delay", "number", "x_setting", "number")),
    )
    assert ways(device) == {("delay", "0x17_delay_zigbee2mqtt"), ("delay_on", "0x17_delay_on_zigbee2mqtt")}


def test_choices_of_different_words_and_numbers_of_different_units_are_two() -> None:
    device = together(
        (setting("mode", "option", name="Mode", options=("eco", "boost")),),
        (foreign("mode", "select", "x_setting", "option", name="Mode", options=("up", "down")),),
    )
    assert len(device.parts) == 2
    one, other = (
        Part(id="t", service_type="x_setting", capabilities=(Capability(name="number", unit=unit),))
        for unit in ("s", "min")
    )
    assert match([candidates([one], ())], candidates([other], ())) == {}


def test_two_thermometers_with_different_names_are_two() -> None:
    """One that is called as what it measures is the nameless one."""
    inner = made("a", "temperature_sensor", "temperature", name="Device temperature")
    plain = made("b", "temperature_sensor", "temperature", name="Temperature")
    nameless = made("c", "temperature_sensor", "temperature", reads="other")
    assert match([candidates([inner], ())], candidates([nameless], ())) == {}
    assert match([candidates([plain], ())], candidates([nameless], ())) == {0: 0}


def test_a_command_topic_of_its_own_says_who_a_part_is() -> None:
    relays = [made(f"POWER{n}", "switch", "on_off", writes=f"cmnd/plug/POWER{n}") for n in (1, 2)]
    others = [made(f"AB_RL_{n}", "switch", "on_off", writes=f"cmnd/plug/POWER{n}") for n in (2, 1)]
    groups = [[one] for one in candidates(relays, ())]
    assert match(groups, candidates(others, ())) == {0: 1, 1: 0}


@pytest.mark.parametrize("part_id", ["", "_", "a" * 5_000, "_".join(str(n) for n in range(2_000))])
def test_ids_of_any_form_are_taken(part_id: str) -> None:
    one = candidates([made(part_id, "light", "on_off", writes="a")], ())
    other = made(part_id, "light", "on_off", reads="other", writes="b")
    assert match([one], candidates([other], (f"id:{part_id}",))) == {0: 0}


@pytest.mark.parametrize(
    ("own", "other"),
    [
        (
            made("apparent_power", "electrical_meter", "measurement"),
            foreign("SINSTS", "sensor", "electrical_meter", "measurement", writes=""),
        ),
        (
            made("current", "electrical_meter", "current", name="Current"),
            foreign("current_phase_b", "sensor", "electrical_meter", "current", writes=""),
        ),
        (
            made("switch_l2", "switch", "on_off", name="l2", writes=SET),
            foreign("switch_l1", "switch", "switch", "on_off", name="L1"),
        ),
        (
            made("switch", "switch", "on_off", writes=SET),
            foreign("switch_beeper", "switch", "switch", "on_off", name="Beeper"),
        ),
        (
            made("light_l2", "light", "on_off", name="l2", writes=SET),
            foreign("light_l1", "light", "light", "on_off", name="L1", reads=f"{STATE}/l1", writes=f"{STATE}/l1/set"),
        ),
    ],
)
def test_parts_of_which_each_side_knows_only_one_are_two(own: Part, other: Part) -> None:
    """As long as Zigbee2MQTT's list is read and its announcements to Home Assistant come one after the other."""
    quality = made("linkquality", "x_sensor", "measurement")
    same = foreign("linkquality", "sensor", "x_sensor", "measurement", writes="")
    device = together((own, quality), (other, same))
    assert sorted(len(one.routes) for one in device.parts) == [1, 1, 2]


WORDS = ["switch", "delay", "on", "0x17", "l1"]
ids = st.lists(st.sampled_from(WORDS), min_size=1, max_size=3).map("_".join)
abilities = st.sampled_from([("on_off",), ("on_off", "level"), ("number",), ("push",), ("push", "locate")])
parts = st.builds(
    lambda part_id, kind, names, name, category, topic: made(
        part_id, kind, *names, name=name, category=category, writes=topic
    ),
    ids,
    st.sampled_from(["switch", "light", "x_setting"]),
    abilities,
    st.sampled_from(["", "Delay", "On"]),
    st.sampled_from(["", "config"]),
    st.sampled_from(["", SET, f"{SET}/on"]),
)
sources = st.lists(parts, max_size=4, unique_by=lambda one: one.id)


@given(
    st.tuples(sources, sources, sources).flatmap(
        lambda found: st.tuples(
            st.just(found),
            st.permutations([(number, one) for number, some in enumerate(found[1:]) for one in range(len(some))]),
            st.integers(0, 8),
        )
    )
)
def test_random_announcements_of_three_conventions_have_one_result_in_every_order(
    drawn: tuple[tuple[list[Part], ...], list[tuple[int, int]], int],
) -> None:
    """Each part is told of by one way, and nobody can what no way of it can."""
    (native, *others), order, at = drawn
    made_of = []
    for steps in (sorted(order), order):
        index = DeviceIndex(forget_after=1000.0)
        for number, step in enumerate((*steps, None)):
            if native and (number == min(at, len(steps)) if steps is order else number == 0):
                index.observe(sighting("native", "zigbee2mqtt", *native))
            if step is not None:
                convention, one = step
                index.observe(
                    sighting(f"{convention}/{one}", ("homeassistant", "other")[convention], others[convention][one])
                )
        made_of.append({contents(one) for one in index.devices()})
        for device in index.devices():
            routes = [(way.key, way.part) for part in device.parts for way in part.routes]
            assert len(routes) == len(set(routes)) == len(native) + len(order)
            for part in device.parts:
                assert len({way.convention for way in part.routes}) == len(part.routes)
    assert made_of[0] == made_of[1]


def test_parts_that_their_ids_decide_are_compared_once() -> None:
    """A house of 4,478 Zigbee models has 36,685 parts that two programs announce."""
    names = [f"value_{number}" for number in range(30)]
    own = candidates([setting(name, "number", name=name, writes=SET) for name in names], (IEEE,))
    others = candidates([foreign(name, "number", "x_setting", "number", name=name) for name in names], FOREIGN)
    found: dict[int, int] = {}
    assert calls(lambda: found.update(match([[one] for one in own], others))) < 40 * len(names)
    assert found == {number: number for number in range(len(names))}
    assert calls(lambda: match((), others)) < 10


def sighting(key: str, convention: str, *told: Part) -> Sighting:
    place = {"key": f"{convention}:{key}", "announced_on": f"{convention}/motor/{key}/config"}
    return SIGHTING.model_copy(update={**place, "convention": convention, "parts": told})


SIGHTING = sighting_of("", name="Motor", service_type="x_unknown", identifiers=(IEEE,), owns=(STATE,), confirmed=False)
