"""Entities of Home Assistant as devices."""

from datetime import UTC, datetime

import pytest

from homebot.control.command import device_settings
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, UnableError, WireError, WrongCodeError
from homebot.integrations.homeassistant.formats.states.entity import HomeAssistantEntity, ServiceCall
from homebot.integrations.homeassistant.gateway.entities import HomeAssistantEntities

NOW = datetime(2026, 11, 22, 8, 0, tzinfo=UTC)
HUB = {
    "id": "d1",
    "name": "Hall hub",
    "name_by_user": None,
    "manufacturer": "Acme",
    "model": "H1",
    "area_id": "hall",
    "identifiers": [["acme", "h1"]],
}


def entity_entry(entity_id: str, **fields: object) -> dict[str, object]:
    return {"entity_id": entity_id, "id": f"r-{entity_id}", "unique_id": entity_id.upper(), **fields}


def home(*entries: dict[str, object], device: dict[str, object] | None = None) -> HomeAssistantEntities:
    """A Home Assistant with these entries, and one device."""
    entities = HomeAssistantEntities(100)
    entities.registries.put("device", [{**HUB, **(device or {})}])
    entities.registries.put("entity", list(entries))
    entities.registries.put("area", [{"area_id": "hall", "name": "Hall", "floor_id": "f1"}])
    entities.registries.put("floor", [{"floor_id": "f1", "name": "Ground floor"}])
    entities.registries.put("label", [{"label_id": "night", "name": "At night"}])
    return entities


def state(text: str, **attributes: object) -> dict[str, object]:
    return {"s": text, "a": attributes, "c": "1", "lc": NOW.timestamp()}


def only(entity_id: str, text: str, **attributes: object) -> HomeAssistantEntity:
    """An entity by itself, in this state."""
    entities = home()
    entities.put(entity_id, state(text, **attributes), is_new=True)
    ((entity,),) = entities.regroup().values()
    entity.part()
    return entity


def called(entity: HomeAssistantEntity, capability: str, value: PlainValue) -> ServiceCall:
    """The call for a command as control sends it: on the grid of the capability."""
    (sent,) = device_settings({capability: value}, entity.part()).values()
    return entity.call(capability, sent)


def test_a_vacuum_and_a_mower_list_the_moves_of_their_features() -> None:
    """By them a person says "start" and "dock"."""
    vacuum = only("vacuum.roomba", "docked", supported_features=4 | 16 | 8192)
    mower = only("lawn_mower.automower", "docked", supported_features=1 | 4)
    assert [vacuum.part().capabilities[0].options, mower.part().capabilities[0].options] == [
        ("cleaning", "paused", "returning"),
        ("mowing", "docked"),
    ]


@pytest.mark.parametrize(("others", "aliases"), [((), "Reading lamp"), (("light.second",), None)])
def test_a_device_with_one_entity_is_called_as_home_assistant_shows_that(
    others: tuple[str, ...], aliases: str | None
) -> None:
    """It need not have the name of its device; of several, each is a part with a name."""
    names = ("light.hall", *others)
    entities = home(*(entity_entry(one, device_id="d1", name="Reading lamp") for one in names))
    for one in names:
        entities.put(one, state("on", friendly_name="Reading lamp"), is_new=True)
    entities.regroup()
    assert entities.device("d1").metadata.get("aliases") == aliases


def test_the_entities_of_a_device_are_its_parts_and_its_area_its_room() -> None:
    """Labels are tags, and the floor, the aliases and the entity ids are facts."""
    lamp = entity_entry("light.hall", device_id="d1", original_name="Lamp", labels=["night"], aliases=["Big lamp"])
    power = entity_entry("sensor.power", device_id="d1", original_name="Power", entity_category="diagnostic")
    hidden = entity_entry("switch.led", device_id="d1", name="LED", hidden_by="user")
    disabled = entity_entry("switch.other", device_id="d1", disabled_by="user")
    entities = home(lamp, power, hidden, disabled)
    for entity_id in ("sensor.power", "switch.led", "switch.other", "light.hall"):
        entities.put(entity_id, state("on"), is_new=True)
    assert list(entities.regroup()) == ["d1"]
    device = entities.describe("d1")
    assert (device.name, device.area, device.native) == ("Hall hub", "Hall", False)
    assert [(one.id, one.name, one.category) for one in device.parts] == [
        ("light_LIGHT.HALL", "Lamp", ""),
        ("switch_SWITCH.LED", "LED", "config"),
        ("sensor_SENSOR.POWER", "Power", "diagnostic"),
    ]
    assert device.metadata == {
        "manufacturer": "Acme",
        "model": "H1",
        "floor": "Ground floor",
        "tags": "At night",
        "aliases": "Big lamp",
        "entities": "light.hall, switch.led, sensor.power",
    }


@pytest.mark.parametrize(
    ("of_device", "of_lamp", "of_fan", "room"),
    [
        ("hall", "attic", "attic", "Attic"),
        ("hall", "attic", None, "Hall"),
        (None, None, "attic", "Attic"),
        (None, None, None, ""),
    ],
)
def test_the_area_of_all_entities_outranks_that_of_their_device(
    of_device: str | None, of_lamp: str | None, of_fan: str | None, room: str
) -> None:
    """Home Assistant shows each entity in its own area, if it has one; settings stay in that of the device."""
    entries = [
        entity_entry("light.a", device_id="d1", area_id=of_lamp),
        entity_entry("fan.a", device_id="d1", area_id=of_fan),
        entity_entry("sensor.signal", device_id="d1", entity_category="diagnostic"),
    ]
    entities = home(*entries, device={"area_id": of_device})
    entities.registries.put("area", [{"area_id": one, "name": one.capitalize()} for one in ("hall", "attic")])
    for one in ("light.a", "fan.a", "sensor.signal"):
        entities.put(one, state("on"), is_new=True)
    entities.regroup()
    assert entities.device("d1").area == room


@pytest.mark.parametrize(
    ("device", "expected"),
    [
        ({"identifiers": [["mqtt", "zigbee2mqtt_0x00158d0001abcdef"]]}, "eui64:00158d0001abcdef"),
        ({"connections": [["mac", "AA:BB:CC:00:11:22"]]}, "mac:aabbcc001122"),
        ({"connections": [["zigbee", "00:15:8d:00:01:ab:cd:ef"]]}, "eui64:00158d0001abcdef"),
        ({"identifiers": [["matter", "serial_4711-A"]]}, "id:4711-A"),
        ({"identifiers": [["zwave_js", "3245146787-12"]]}, "id:zwavejs2mqtt_0xc16d02a3_node12"),
        ({"identifiers": [["zwave_js", "3245146787-12-134:2:90"]]}, "id:zwavejs2mqtt_0xc16d02a3_node12"),
        ({"identifiers": [["hue", "uuid-1"]]}, "id:hue:uuid-1"),
        ({"connections": [["upnp", "uuid:1-2"]]}, "id:upnp:uuid:1-2"),
    ],
)
def test_a_device_has_the_identifiers_that_its_own_protocol_gives_it(device: dict[str, object], expected: str) -> None:
    entities = home(entity_entry("light.hall", device_id="d1"), device=device)
    entities.put("light.hall", state("on"), is_new=True)
    entities.regroup()
    assert expected in entities.describe("d1").identifiers


@pytest.mark.parametrize(
    "device", [{"identifiers": [["mqtt", "homebot_villa_robot"]]}, {"disabled_by": "user"}], ids=["own", "disabled"]
)
def test_what_homebot_shows_to_home_assistant_does_not_come_back(device: dict[str, object]) -> None:
    entities = home(entity_entry("light.hall", device_id="d1"), device=device)
    entities.put("light.hall", state("on"), is_new=True)
    assert entities.is_new("light.hall")
    assert entities.regroup() == {}
    assert not entities.is_new("light.hall")  # so that its changes cause no look into the registries


@pytest.mark.parametrize(
    ("entity_id", "attributes"),
    [
        ("sensor.code", {"friendly_name": "Keypad code"}),
        ("scene.leave", {"entity_id": ["light.hall", "lock.door"]}),
        ("scene.come", {"entity_id": ["light.garage_door", "switch.garage_door"]}),
        ("script.leave", {}),
        ("switch.all", {"entity_id": ["switch.lamp", "switch.garage_door"]}),
        ("light.hall", {"is_hue_group": True, "lights": ["Hall lamp"]}),
        ("light.hall", {"is_deconz_group": True}),
        ("cover.all", {"entity_id": ["cover.blind", "cover.garage_door"]}),
        ("light.odd", {"entity_id": ["light.hall", "lock.door"]}),
        ("fan.all", {"entity_id": ["fan.hall"]}),
    ],
)
def test_secrets_groups_and_scenes_that_move_locks_are_left_out(entity_id: str, attributes: dict[str, object]) -> None:
    entities = home()
    entities.put(entity_id, state("on", **attributes), is_new=True)
    assert entities.regroup() == {}


def test_a_scene_of_lamps_and_plugs_is_read() -> None:
    entities = home(entity_entry("light.garage_door"))
    entities.put("scene.film", state("on", entity_id=["light.garage_door", "switch.projector"]), is_new=True)
    (key,) = entities.regroup()
    assert entities.describe(key).parts[0].members == ("#light_LIGHT.GARAGE_DOOR", "#switch_projector")


@pytest.mark.parametrize(
    ("entity_id", "attribute", "members"),
    [
        ("light.hall", "entity_id", ["light.one", "light.garage_door"]),
        ("light.zha_group", "group_entities", ["light.one"]),
        ("switch.plugs", "entity_id", ["switch.one", "switch.two"]),
        ("cover.blinds", "entity_id", ["cover.left", "cover.right"]),
    ],
)
def test_a_group_of_lights_switches_or_covers_is_a_way_to_reach_them(
    entity_id: str, attribute: str, members: list[str]
) -> None:
    entities = home()
    entities.put(entity_id, state("on", **{attribute: members}), is_new=True)
    (key,) = entities.regroup()
    (part,) = entities.describe(key).parts
    assert (part.is_group, len(part.members)) == (True, len(members))


@pytest.mark.parametrize(
    ("inner", "members"),
    [
        (["light.two", "light.three"], ["#light_one", "#light_two", "#light_three"]),
        (["light.all", "light.two", "light.one"], ["#light_one", "#light_two"]),
    ],
)
def test_the_members_of_a_group_in_a_group_are_members_also_if_they_contain_each_other(
    inner: list[str], members: list[str]
) -> None:
    entities = home()
    entities.put("light.all", state("on", entity_id=["light.one", "light.inner", "light.inner"]), is_new=True)
    entities.put("light.inner", state("on", entity_id=inner), is_new=True)
    key = next(key for key, found in entities.regroup().items() if found[0].entity_id == "light.all")
    assert list(entities.describe(key).parts[0].members) == members


def test_a_group_with_a_garage_door_in_an_inner_group_is_left_out() -> None:
    entities = home()
    entities.put("switch.all", state("on", entity_id=["switch.lamp", "switch.inner"]), is_new=True)
    entities.put("switch.inner", state("on", entity_id=["switch.garage_door"]), is_new=True)
    assert entities.regroup() == {}


def test_a_group_of_sensors_is_read() -> None:
    entities = home()
    entities.put("binary_sensor.any_motion", state("on", entity_id=["binary_sensor.hall"]), is_new=True)
    assert entities.regroup()


def test_unavailable_is_unreachable_and_unknown_is_unknown() -> None:
    gone, unknown = only("switch.a", "unavailable"), only("switch.a", "unknown")
    assert (gone.is_available, dict(gone.read(is_change=True))) == (False, {})
    assert (unknown.is_available, unknown.read(is_change=True)) == (True, {"on_off": None})


def test_what_an_unknown_state_does_not_tell_its_attributes_do() -> None:
    """A thermostat that has not reported its mode still measures."""
    told = {"hvac_modes": ["heat", "off"], "current_temperature": 21.5, "temperature": 20, "supported_features": 1}
    values = only("climate.a", "unknown", **told).read(is_change=False)
    assert (values["local_temperature"], values["heating_setpoint"]) == (21.5, 20.0)
    assert (values["thermostat_mode"], values["on_off"]) == (None, None)


def test_a_renamed_entity_is_the_same_part_and_one_that_is_reloaded_stays() -> None:
    entities = home(entity_entry("light.hall", device_id="d1"))
    entities.put("light.hall", state("on"), is_new=True)
    entities.put("switch.yaml", state("on"), is_new=True)
    entities.regroup()
    before = entities.describe("d1").parts
    renamed = {**entity_entry("light.hall", device_id="d1"), "entity_id": "light.new"}
    entities.lose("light.hall")
    entities.lose("switch.yaml")
    entities.put("light.new", state("on"), is_new=True)
    entities.registries.put("entity", [renamed])
    assert list(entities.regroup()) == ["switch.yaml", "d1"] or list(entities.regroup()) == ["d1", "switch.yaml"]
    assert [one.id for one in entities.describe("d1").parts] == [one.id for one in before]
    assert entities.describe("d1").parts[0].payloads != before[0].payloads  # an approval was for the old entity
    with pytest.raises(LinkError, match="unavailable"):
        entities.entity("switch.yaml", "switch_yaml")
    assert list(entities.regroup(forget=True)) == ["d1"]
    with pytest.raises(UnableError):
        entities.entity("switch.yaml", "switch_yaml")


def test_entities_of_two_integrations_with_one_id_are_two_parts_of_their_device() -> None:
    entries = [{**entity_entry(f"light.{name}", device_id="d1"), "unique_id": "aa"} for name in ("a", "b")]
    entities = home(*entries)
    for name in ("a", "b"):
        entities.put(f"light.{name}", state("on"), is_new=True)
    entities.regroup()
    assert [one.id for one in entities.describe("d1").parts] == ["light_aa", "r-light.b"]
    assert entities.entity("d1", "r-light.b").entity_id == "light.b"


def test_entities_beyond_the_limit_are_left_out_and_counted() -> None:
    entities = HomeAssistantEntities(1)
    for number in range(3):
        entities.put(f"light.l{number}", state("on"), is_new=True)
    assert (len(entities.regroup()), entities.left_out) == (1, 2)


def test_an_event_is_reported_when_it_happens_and_not_again_when_it_is_restored() -> None:
    entity = only("event.bell", "unknown", event_types=["ring"], event_type=None)
    entity.put({"s": NOW.isoformat(), "a": {"event_type": "ring"}, "lc": NOW.timestamp() + 0.1}, is_new=False)
    assert entity.read(is_change=True) == {"press": "ring"}
    assert entity.read(is_change=False) == {}
    entity.put({"s": NOW.isoformat(), "lc": NOW.timestamp() + 3600}, is_new=False)
    assert entity.read(is_change=True) == {}


def test_an_assumed_state_proves_nothing() -> None:
    (capability,) = only("switch.a", "on", assumed_state=True).part().capabilities
    assert capability.echoed


@pytest.mark.parametrize(
    ("modes", "features", "setpoints"),
    [
        (["off", "cool", "dry"], 3, {"cooling_setpoint"}),  # LG's air conditioners
        (["off", "heat"], 3, {"heating_setpoint"}),
        (["off", "heat_cool"], 2, {"heating_setpoint", "cooling_setpoint"}),
        (["off", "auto"], 2, {"heating_setpoint", "cooling_setpoint"}),
        (["off", "auto"], 1, {"heating_setpoint"}),
        (["off", "heat"], 0, set()),
    ],
)
def test_a_thermostat_has_the_setpoints_of_its_modes(modes: list[str], features: int, setpoints: set[str]) -> None:
    part = only("climate.a", "off", hvac_modes=modes, supported_features=features, min_temp=7, max_temp=30).part()
    assert {one.name for one in part.capabilities if one.name.endswith("setpoint")} == setpoints


@pytest.mark.parametrize(
    ("modes", "has_switch"), [(["heat"], False), (["heat", "auto"], False), (["off", "heat"], True)]
)
def test_a_thermostat_that_cannot_be_off_has_no_switch(modes: list[str], *, has_switch: bool) -> None:
    part = only("climate.a", "heat", hvac_modes=modes, supported_features=1).part()
    assert ("on_off" in {one.name for one in part.capabilities}) is has_switch


def test_vanes_of_an_air_conditioner_swing_to_the_sides() -> None:
    """``ClimateEntityFeature.SWING_HORIZONTAL_MODE``."""
    modes = {"swing_horizontal_modes": ["off", "wide"], "swing_horizontal_mode": "wide"}
    vanes = only("climate.a", "cool", hvac_modes=["off", "cool"], supported_features=512, **modes)
    assert vanes.read(is_change=True)["swing_horizontal_mode"] == "wide"
    call = vanes.call("swing_horizontal_mode", "off")
    assert (call.service, call.data) == ("set_swing_horizontal_mode", {"swing_horizontal_mode": "off"})


def test_a_projector_is_no_speaker_and_off_in_standby() -> None:
    """A Roku that is switched off reports standby."""
    projector = only("media_player.a", "standby", device_class="projector", supported_features=384)
    assert projector.part().service_type == "video_player"
    assert projector.read(is_change=True)["on_off"] is False


def test_a_player_that_only_pauses_refuses_to_stop() -> None:
    player = only("media_player.a", "playing", supported_features=1 | 16_384, is_volume_muted=True)
    assert player.read(is_change=True) == {"playback": "playing", "media_title": None, "media_artist": None}
    assert player.call("playback", "paused").service == "media_pause"
    with pytest.raises(RefusedError, match="playing, paused"):
        player.call("playback", "stopped")


@pytest.mark.parametrize(
    ("media", "called"),
    [
        ("http://radio.example/Live", {"media_content_id": "http://radio.example/Live", "media_content_type": "music"}),
        ("playlist spotify:1 b", {"media_content_id": "spotify:1 b", "media_content_type": "playlist"}),
        ("announce music a", {"media_content_id": "a", "media_content_type": "music", "announce": True}),
        ("announce", {"media_content_id": "announce", "media_content_type": "music"}),
    ],
)
def test_a_player_plays_an_address_by_its_type(media: str, called: dict[str, object]) -> None:
    player = only("media_player.a", "idle", supported_features=512)
    call = player.call("media", media)
    assert (call.service, call.data) == ("play_media", called)
    with pytest.raises(RefusedError, match="it takes the address of a stream"):
        player.call("media", " ")


@pytest.mark.parametrize(
    ("entity_id", "shown", "attributes", "told", "called"),
    [
        ("input_datetime.a", "07:00:00", {"has_time": True}, "07:00:00", {"time": "07:00:00"}),
        ("input_datetime.a", "2026-11-22", {"has_date": True}, "2026-11-22", {"date": "2026-11-22"}),
        (
            "input_datetime.a",
            "2026-11-22 07:00:00",
            {"has_date": True, "has_time": True},
            "2026-11-22T07:00:00",
            {"datetime": "2026-11-22T07:00:00"},
        ),
        ("counter.a", "5", {}, 5.0, {"value": 5}),
    ],
)
def test_a_helper_is_set_to_what_it_shows(
    entity_id: str, shown: str, attributes: dict[str, object], told: PlainValue, called: dict[str, object]
) -> None:
    helper = only(entity_id, shown, **attributes)
    ((name, value),) = helper.read(is_change=True).items()
    assert (value, helper.call(name, value).data) == (told, called)


def test_a_helper_takes_no_time_zone() -> None:
    """Home Assistant drops it without a word, and sets the same hour of its own zone."""
    helper = only("input_datetime.a", "2026-11-22 07:00:00", has_date=True, has_time=True)
    with pytest.raises(RefusedError, match="a datetime without a time zone"):
        helper.call("text", "2026-11-22T07:00:00+00:00")


def test_a_person_has_a_place() -> None:
    assert only("person.ann", "home").read(is_change=True) == {"place": "home"}


def test_degrees_fahrenheit_are_converted_both_ways() -> None:
    entities = HomeAssistantEntities(9)
    entities.celsius = False
    told = {"hvac_modes": ["heat", "off"], "min_temp": 45, "max_temp": 95, "temperature": 68, "supported_features": 1}
    entities.put("climate.hall", state("heat", **told), is_new=True)
    ((entity,),) = entities.regroup().values()
    entity.part()
    assert entity.read(is_change=False)["heating_setpoint"] == 20.0
    assert called(entity, "heating_setpoint", 21.0).data == {"temperature": 70.0}


@pytest.mark.parametrize(
    ("entity_id", "attributes", "capability", "value", "called"),
    [
        (
            "light.a",
            {"supported_color_modes": ["rgbw"]},
            "color",
            (120.0, 50.0),
            ("turn_on", {"hs_color": (120.0, 50.0)}),
        ),
        ("light.a", {"supported_color_modes": ["hs"]}, "level", 0.0, ("turn_off", {})),
        ("valve.a", {"supported_features": 15}, "valve", "open", ("open_valve", {})),
        ("lawn_mower.a", {"supported_features": 7}, "mower", "docked", ("dock", {})),
        ("cover.a", {"supported_features": 240}, "tilt", 30.0, ("set_cover_tilt_position", {"tilt_position": 30})),
        ("cover.a", {"supported_features": 112}, "tilt", 0.0, ("close_cover_tilt", {})),
        ("cover.a", {"supported_features": 112}, "tilt", 100.0, ("open_cover_tilt", {})),
        ("lock.a", {"code_format": "\\d+"}, "lock", "unlocked", ("unlock", {"code": "1234"})),
        ("notify.a", {}, "text", "Dinner!", ("send_message", {"message": "Dinner!"})),
    ],
)
def test_a_command_is_the_call_of_a_service(
    entity_id: str, attributes: dict[str, object], capability: str, value: PlainValue, called: tuple[str, object]
) -> None:
    call = only(entity_id, "off", **attributes).call(capability, value, code="1234" if "lock" in entity_id else "")
    assert (call.entity_id, call.service, dict(call.data)) == (entity_id, *called)


def test_a_position_that_cannot_be_set_is_read() -> None:
    """A template cover with a ``position_template`` alone has one."""
    cover = only("cover.a", "open", supported_features=3, current_position=30)
    assert cover.read(is_change=False) == {"movement": "open", "position": 30.0}
    assert [(one.name, one.settable) for one in cover.part().capabilities] == [("movement", True), ("position", False)]


@pytest.mark.parametrize(
    ("code_format", "code"), [("\\d+", "digits"), ("number", "digits"), ("text", "text"), ("^.{4}$", "text")]
)
def test_a_lock_with_a_code_needs_it(code_format: str, code: str) -> None:
    lock = only("lock.a", "locked", code_format=code_format)
    with pytest.raises(WrongCodeError):
        lock.call("lock", "unlocked")
    assert lock.part().capabilities[0].code == code


def test_slats_without_a_position_have_two_ends() -> None:
    with pytest.raises(RefusedError, match="only open"):
        only("cover.a", "open", supported_features=112).call("tilt", 50.0)


def test_a_transition_is_passed_on_and_an_unknown_capability_refused() -> None:
    plain = only("light.a", "on", supported_color_modes=["brightness"])
    lamp = only("light.a", "on", supported_color_modes=["brightness"], supported_features=32)
    assert plain.call("level", 50.0, transition=2.0).data == {"brightness": 128}  # Home Assistant leaves it out too
    assert lamp.call("level", 50.0, transition=2.0).data == {"brightness": 128, "transition": 2.0}
    assert (plain.part().fades, lamp.part().fades, only("scene.film", "unknown").part().fades) == (False, True, True)
    assert only("scene.film", "unknown").call("scene", True, transition=2.0).data == {"transition": 2.0}
    with pytest.raises(RefusedError, match="this part takes on_off, level"):
        lamp.call("color", (1.0, 2.0))


@pytest.mark.parametrize("change", [5, {}, {"s": None}, {"+": 3}], ids=str)
def test_an_invalid_change_is_refused(change: object) -> None:
    entities = home()
    entities.put("light.a", state("on"), is_new=True)
    with pytest.raises(WireError, match="the state of light"):
        entities.put("light.a", change, is_new=False)


def test_the_second_of_two_temperatures_leaves_the_first_as_it_was_set() -> None:
    """Nest's thermostat reports what it was set to a second later."""
    thermostat = only("climate.nest", "heat_cool", hvac_modes=["off", "heat_cool"], supported_features=2)
    thermostat.put({"a": {"target_temp_low": 20.0, "target_temp_high": 24.0}}, is_new=False)
    thermostat.expect(thermostat.call("cooling_setpoint", 25.0))
    heat = thermostat.call("heating_setpoint", 21.0)
    assert heat.data == {"target_temp_low": 21.0, "target_temp_high": 25.0}
    thermostat.expect(heat)
    thermostat.put({"a": {"target_temp_low": 19.0, "target_temp_high": 24.0}}, is_new=False)  # by hand
    assert thermostat.call("heating_setpoint", 20.0).data == {"target_temp_low": 20.0, "target_temp_high": 24.0}


def test_a_temperature_after_a_mode_is_that_of_the_mode() -> None:
    thermostat = only("climate.nest", "heat", hvac_modes=["off", "heat", "heat_cool"], supported_features=3)
    thermostat.put({"a": {"target_temp_low": 20.0, "target_temp_high": 24.0}}, is_new=False)
    thermostat.expect(thermostat.call("thermostat_mode", "heat_cool"))
    assert thermostat.call("heating_setpoint", 21.0).data == {"target_temp_low": 21.0, "target_temp_high": 24.0}


def test_the_icon_of_what_can_be_set_is_its_kind_without_a_class() -> None:
    assert only("switch.one", "on", icon="mdi:pipe-valve", device_class="outlet").part().tag == "mdi:pipe-valve"
    assert only("cover.one", "open", icon="mdi:gate", device_class="blind").part().tag == "blind"
    assert only("sensor.one", "1", icon="mdi:gate").part().tag == ""


def test_a_text_is_checked_by_its_pattern() -> None:
    code = only("input_text.code", "1234", pattern="[0-9]{4}$", min=0, max=9)
    assert code.call("text", "4321").data == {"value": "4321"}
    with pytest.raises(RefusedError, match="it takes a text that matches"):
        code.call("text", "43a1")
