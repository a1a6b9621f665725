"""Entities of products, with the features that their integrations state."""

import pytest
from tests.integrations.homeassistant.gateway.test_entities import HUB, called, entity_entry, home, only, state

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

COOLER = {"hvac_modes": ["cool", "heat", "dry", "fan_only", "off"], "min_temp": 16, "max_temp": 30}
VENSTAR = {"hvac_modes": ["heat", "cool", "off", "auto"], "min_temp": 7, "max_temp": 35}


@pytest.mark.parametrize(
    ("entity_id", "attributes", "capability", "value", "expected"),
    [
        # Gree, Daikin, Sensibo: on again as it was, which no mode says; before 2024.2 there was no service for it
        ("climate.a", {**COOLER, "supported_features": 385}, "on_off", True, ("turn_on", {})),
        ("climate.a", {**COOLER, "supported_features": 385}, "on_off", False, ("turn_off", {})),
        ("climate.a", {**COOLER, "supported_features": 1}, "on_off", True, ("set_hvac_mode", {"hvac_mode": "heat"})),
        # Tesla's protection of the cabin, LG's air conditioners: whole steps
        (
            "climate.a",
            {**COOLER, "supported_features": 1, "target_temp_step": 5},
            "cooling_setpoint",
            28.0,
            ("set_temperature", {"temperature": 30.0}),
        ),
        ("media_player.webos", {"supported_features": 24_381}, "on_off", False, ("turn_off", {})),
        ("siren.chime", {"supported_features": 5, "available_tones": ["ding"]}, "on_off", True, ("turn_on", {})),
        ("lawn_mower.goat", {"supported_features": 15}, "mower", "idle", ("stop", {})),
    ],
)
def test_a_command_is_the_service_that_the_product_has(
    entity_id: str, attributes: dict[str, object], capability: str, value: PlainValue, expected: tuple[str, object]
) -> None:
    call = called(only(entity_id, "off", **attributes), capability, value)
    assert (call.service, dict(call.data)) == expected


@pytest.mark.parametrize(
    ("entity_id", "features", "value", "way"),
    [("media_player.webos", 24_381, True, "turned off"), ("siren.chime", 5, False, "turned on")],
)
def test_what_has_one_service_is_switched_one_way(entity_id: str, features: int, *, value: bool, way: str) -> None:
    """A television that sleeps hears nothing; a chime of Ring ends by itself."""
    with pytest.raises(RefusedError, match=way):
        only(entity_id, "on", supported_features=features).call("on_off", value)


def test_seventy_degrees_fahrenheit_are_not_sixty_nine() -> None:
    """LG's air conditioners cut 69.998 off."""
    entities = home()
    entities.celsius = False
    told = {"hvac_modes": ["off", "cool"], "supported_features": 1, "target_temp_step": 1}
    entities.put("climate.lg", state("cool", min_temp=64, max_temp=86, **told), is_new=True)
    ((cooler,),) = entities.regroup().values()
    cooler.part()
    assert called(cooler, "cooling_setpoint", 21.11).data == {"temperature": 70.0}


def test_two_targets_without_the_single_one_are_both_ends() -> None:
    """Venstar's mode for both is ``auto``."""
    ends = {"temperature": None, "target_temp_low": 20.0, "target_temp_high": 25.0}
    thermostat = only("climate.venstar", "auto", supported_features=3, **VENSTAR, **ends)
    values = thermostat.read(is_change=False)
    assert (values["heating_setpoint"], values["cooling_setpoint"]) == (20.0, 25.0)
    call = thermostat.call("cooling_setpoint", 24.0)
    assert call.data == {"target_temp_low": 20.0, "target_temp_high": 24.0}


@pytest.mark.parametrize(
    ("entity_id", "capability", "value"),
    [("lock.yale", "lock", "locked"), ("alarm_control_panel.verisure", "alarm", "armed_away")],
)
def test_a_code_that_home_assistant_knows_is_not_asked_for(entity_id: str, capability: str, value: str) -> None:
    """Its owner gave it in the settings of the entity."""
    entry = entity_entry(entity_id, options={entity_id.partition(".")[0]: {"default_code": "123456"}})
    entities = home(entry)
    told = {"code_format": r"^\d{6}$", "code_arm_required": True, "supported_features": 2}
    entities.put(entity_id, state("unlocked", **told), is_new=True)
    ((entity,),) = entities.regroup().values()
    assert entity.part().capabilities[0].code == ""
    assert entity.call(capability, value).data == {}


def test_a_water_heater_has_one_target_beside_its_limits() -> None:
    """Matter's and SmartThings' tell these as target_temp_low and target_temp_high, also while they are off."""
    limits = {"target_temp_low": 40, "target_temp_high": 65, "min_temp": 40, "max_temp": 65, "temperature": None}
    heater = only("water_heater.a", "off", supported_features=11, operation_list=["eco", "off"], **limits)
    assert heater.read(is_change=False)["heating_setpoint"] is None
    assert heater.call("heating_setpoint", 55.0).data == {"temperature": 55.0}


def test_a_humidifier_without_a_target_takes_none() -> None:
    """A dehumidifier of Tuya has only speeds."""
    part = only("humidifier.tuya", "on", min_humidity=0, max_humidity=100).part()
    assert [one.name for one in part.capabilities] == ["on_off"]


def test_a_mower_that_stands_on_the_lawn_is_idle() -> None:
    """Husqvarna's Automower is that if it was stopped by hand."""
    assert only("lawn_mower.automower", "idle", supported_features=7).read(is_change=False) == {"mower": "idle"}


@pytest.mark.parametrize(("own", "room"), [(None, "Hall"), ("lawn", "Lawn")])
def test_a_work_area_of_a_mower_is_where_the_mower_is(own: str | None, room: str) -> None:
    """Husqvarna's are child devices since 2026.11."""
    entities = home(entity_entry("number.height", device_id="d2"))
    child = {"id": "d2", "name": "My lawn", "identifiers": [["husqvarna_automower", "1_0"]], "area_id": own}
    entities.registries.put("device", [HUB, {**child, "parent_device_id": "d1"}])
    entities.registries.put("area", [{"area_id": one, "name": one.capitalize()} for one in ("hall", "lawn")])
    entities.put("number.height", state("50"), is_new=True)
    entities.regroup()
    device = entities.describe("d2")
    assert (device.area, device.metadata["via_device"]) == (room, "acme:h1")


def test_the_main_light_of_a_strip_is_a_light_beside_its_segments() -> None:
    """WLED's is a group of the segments of its device: they are dark while it is off."""
    names = {"light.wled": None, "light.wled_main": "Main", "light.wled_segment_1": "Segment 1"}
    entities = home(*(entity_entry(one, device_id="d1", original_name=name) for one, name in names.items()))
    members = {"light.wled_main": ["light.wled", "light.wled_segment_1"]}
    for one in names:
        told = {"supported_color_modes": ["brightness"], "supported_features": 32, "friendly_name": f"Strip {one}"}
        listed = {"group_entities": members[one]} if one in members else {}
        entities.put(one, state("on", **told, **listed), is_new=True)
    (parts,) = entities.regroup().values()
    assert [one.entity_id for one in parts] == ["light.wled_main", "light.wled", "light.wled_segment_1"]
    assert parts[0].part().name == "Main"
    call = parts[0].call("on_off", value=False)
    assert (call.service, call.entity_id) == ("turn_off", "light.wled_main")
