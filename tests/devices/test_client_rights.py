"""What a program outside may command, by the scope that the owner wrote."""

from __future__ import annotations

import pytest
from tests.devices.handles.conftest import device, part

from homebot.control.policies.rights import is_safe
from homebot.devices.always_ask import always_asks, why_device_asks, why_it_asks, why_it_drives
from homebot.devices.client_rights import ALL_RIGHTS, LOCAL_RIGHTS, ClientRights, Right, read_scope
from homebot.devices.device import Device, Fact, KeyValue
from homebot.devices.part import Capability, Category
from homebot.devices.words import ALL_THAT_ASK, HEAT, WATER, Groups
from homebot.errors import UsageError
from homebot.messages import Time

HALL_LAMP = device("hall-lamp", part("light", "on_off"), area="Hall")
KITCHEN_LAMP = device("kitchen-lamp", part("light", "on_off"), area="Kitchen")
HALL_LOCK = device("hall-lock", part("door_lock", "lock"), area="Hall")
GARAGE = device(
    "garage",
    part("closure", "movement", part_id="door", tag="garage_door"),
    part("generic_switch", "push", part_id="button"),
    part("light", "on_off", part_id="lamp"),
    area="Garage",
)
VALVE = device("main-valve", part("water_valve", "valve"))
ALARM = device("alarm", part("x_alarm_panel", "alarm"))
OVEN = device("oven", part("x_unknown", "on_off", advertised="oven"))
ODD_LOCK = device("odd", part("x_setting", "lock"))
HOT_WATER = Capability(name="number", settable=True, unit="°C", bounds=(30.0, 80.0))
BOILER = device("boiler", part("x_setting", name="Hot water", capabilities=(HOT_WATER,)))
RADIATOR = device("radiator valve", part("x_setting", name="Most", capabilities=(HOT_WATER,)))
OVEN_PLUG = device("oven plug", part("plug", "on_off"), area="Kitchen")
GATE_RELAY = device("front gate", part("switch", "on_off"))
GARAGE_COVER = device("garage door", part("window_covering", "movement"))


def of_model(model: str, service_type: str, capability: str) -> Device:
    """Return a device that nobody gave a name."""
    one = device("0x00158d0001", part(service_type, capability))
    return one.model_copy(update={"metadata": (KeyValue(key="model", value=model),)})


GARDEN = of_model("Zigbee smart water valve", "switch", "on_off")
OPENER = of_model("LoraTap garage door opener with wireless sensor", "x_setting", "on_off")
TAGGED = device("saw", part("plug", "on_off")).model_copy(update={"tags": ("always-ask",)})
ASKING = [
    HALL_LOCK,
    GARAGE,
    VALVE,
    ALARM,
    OVEN,
    ODD_LOCK,
    OVEN_PLUG,
    GATE_RELAY,
    GARAGE_COVER,
    BOILER,
    TAGGED,
    GARDEN,
    OPENER,
]


def may(rights: ClientRights, one: Device, number: int = 0) -> bool:
    return rights.may_command(one, one.parts[number], asks=always_asks(one, one.parts[number]))


@pytest.mark.parametrize("one", ASKING, ids=lambda one: one.id)
def test_a_device_that_lets_in_or_floods_or_burns_always_asks(one: Device) -> None:
    assert always_asks(one, one.parts[0])
    assert not may(LOCAL_RIGHTS, one)
    assert not may(read_scope(["act: with on_off or with lock or not light"]), one)
    assert may(read_scope(["act: all"]), one)
    assert may(read_scope([f'act: name="{one.name}"']), one)
    assert may(read_scope([f'act: id="{one.id}"']), one)
    assert may(ALL_RIGHTS, one)


NAMES_THAT_ASK = (
    "valve_group_1, Garage door left, Gate motor 2, Front gate, Main valve, Gates, Back door lock, Door garage, "
    "Door of the garage, Garage left door, GarageDoor, Valve of the garden, Gate to the field, Door opener, "
    "Gate opener 2, Lock relay, Boiler 1, Kitchen oven clock, Open gate, Garage door toggle, Gate impulse, "
    "Open front door, Door open, Open garage, Unlock the front door, Front door unlock, Unlatch, "
    "Front door release, Gate strike, Disarm, Water heater, Immersion heater 2, Hot water, Geyser, Sauna, "
    "Sauna heater, Fireplace left, Garagentor, Garagentor links, Tor, Einfahrtstor auf/zu, Tor Einfahrt, "
    "Haustür, Haustuer Summer, Türschloss, Schloss Haustür, Türöffner unten, Wasserventil Garten, Backofen, "
    "Space heater, Fan heater left, Heizlüfter, Bad Heizluefter, Radiateur soufflant, "
    "Boiler Bad, Oven plug, Porte de garage, Porte du garage gauche, Serrure de la porte d'entrée, "
    "Ouverture portail, Portail voiture, Vanne d'eau, Chauffe-eau, Cancello, Apri cancello, Porta del garage, "
    "Caldaia, Válvula principal, Puerta del garaje, Horno, Garagedeur, Poort openen, Sprinkler zone 1, Heizkessel, "
    "Warmwasserspeicher, Bewässerung Garten, Hauptwasserhahn, Tür öffnen, Arrosage jardin, Ouvrir la porte, "
    "Irrigazione, Apri la porta, Riego, Abrir puerta, CV-ketel, Beregening, Deur openen, "
    "bestin_gas1, Beregnung Rasen 2, Furnace, Fire place, Hot plate, Immersion, Front door, Electric strike, "
    "Sectional door, Kessel, Ofen, Pelletofen, Kamin, Kochfeld, Kochplatte, Gasherd, Heizstab, Tauchsieder, "
    "Warmwasser, Rasensprenger, Sektionaltor, Pforte, Poêle, Cheminée, Cumulus, Ballon d'eau chaude, Plaque de "
    "cuisson, Robinet, Gaz, Ouvre-porte, Estufa, Chimenea, Vitrocerámica, Termo eléctrico, Grifo, Puerta de "
    "entrada, Stufa, Caminetto, Rubinetto, Basculante, Porta d'ingresso, Ketel, Geiser, Haard, Pelletkachel, "
    "Sproeier, Slagboom, Voordeur"
)


RELAYS_AND_BUTTONS = [
    ("plug", "on_off"),
    ("switch", "on_off"),
    ("window_covering", "on_off"),
    ("x_setting", "push"),
    ("x_setting", "option"),
    ("x_scene", "scene"),
]


@pytest.mark.parametrize("name", NAMES_THAT_ASK.split(", "))
def test_a_relay_or_button_asks_whichever_one_its_name_says_it_is(name: str) -> None:
    for service_type, capability in RELAYS_AND_BUTTONS:
        one = device("0x1", part(service_type, capability, name=name))
        assert always_asks(one, one.parts[0]), service_type


def test_a_contact_that_can_be_set_asks() -> None:
    """Who sets it opens what it is the contact of, as a Thing with a property ``open`` has it."""
    one = device("garage", part("contact_sensor", "contact"))
    assert always_asks(one, one.parts[0])


def test_a_choice_without_a_name_is_called_as_its_device() -> None:
    one = device("Garage door", part("x_setting", "option"))
    assert always_asks(one, one.parts[0])


@pytest.mark.parametrize(("name", "asks"), [("", True), ("Volume", False)])
def test_a_text_without_a_name_is_called_as_its_device(name: str, *, asks: bool) -> None:
    """As Home Assistant calls an entity that is announced with the name null."""
    one = device("Unlock door", part("x_setting", "text", name=name))
    assert always_asks(one, one.parts[0]) is asks


def test_a_deed_without_a_name_is_called_by_its_id() -> None:
    """Many an action of a Thing has no title."""
    one = device("Porch", part("generic_switch", "push", part_id="unlockDoor"), part("light", "on_off", part_id="lamp"))
    assert [always_asks(one, each) for each in one.parts] == [True, False]


def test_a_virtual_button_asks_by_its_name() -> None:
    one = device("shelly", part("generic_switch", "push", name="Open gate"))
    assert always_asks(one, one.parts[0])


def test_a_button_asks_by_the_name_of_its_device() -> None:
    one = device("Garage door", part("x_setting", "push", name="Toggle"))
    assert always_asks(one, one.parts[0])


@pytest.mark.parametrize(("category", "tag"), [("config", ""), ("", "restart"), ("", "identify")])
def test_a_button_that_keeps_a_device_in_order_does_not(category: Category, tag: str) -> None:
    one = device("Garage door", part("x_setting", "push", name="Press", category=category, tag=tag))
    assert not always_asks(one, one.parts[0])


@pytest.mark.parametrize("capability", ["option", "state"])
@pytest.mark.parametrize(
    ("name", "asks"),
    [("Gate trigger", True), ("Main valve", True), ("Wasserventil", True), ("Keypad lock", False)],
)
def test_a_setting_asks_by_its_name_but_no_lock_of_its_keys(name: str, capability: str, *, asks: bool) -> None:
    one = device("yard", part("x_setting", capability, name=name, category="config"))
    assert always_asks(one, one.parts[0]) is asks


def test_a_choice_does_not_ask_by_the_name_of_its_device() -> None:
    one = device("Front gate", part("x_setting", "option", name="Sensitivity"))
    assert not always_asks(one, one.parts[0])


OTHER_NAMES = (
    "Heater, Towel heater, Kettle, Iron, Lüfter, Heizlüfter Lampe, "
    "Gate light, Lock monitor, Plug, Garage, Door, Door lamp, Garage light, Valve battery, Heizung Bad, "
    "Door bell garage, Garage door light, Garage heater left, Gate lamp 2, Valve amplifier, Front left, "
    "Navigate, Block heater, Child lock, Child lock 2, Clock, Gateway, Letter opener, Door sensor 1, EV charger, "
    "Door open alarm, Window open detection, Open, Toggle, Release, Door chime, Stop, Hot water pump, "
    "Cold water, Sauna light, Fireplace lamp, Boiler room fan, Boilerraum, Cooker hood, Garagentor Licht, "
    "Torbeleuchtung, Hauslicht, Ventilator, Motor, Monitor, Store, Kinderzimmer, Radiator, Lampe du portail, "
    "Sonnette portail, Porte, Lumière garage, Luce cancello, Luz puerta garaje, Poortlamp, Deurbel poort, "
    "Puerta, Gas meter, Gas alarm, Front door light, Kamin Licht, Ofenraum Lampe, Schränke, Channel four"
)


@pytest.mark.parametrize("name", OTHER_NAMES.split(", "))
def test_a_plug_or_button_of_another_name_does_not(name: str) -> None:
    for one in (device(name, part("plug", "on_off")), device(name, part("x_setting", "push"))):
        assert not always_asks(one, one.parts[0])
        assert may(LOCAL_RIGHTS, one)


MODELS_THAT_ASK = (
    "Hilo water heater controller, Calypso smart water heater controller, Water heater switch, "
    "Smart Boiler Switch, Boiler control relay module used in Enel Homix system, "
    "Dry contact switch for central heating boilers, "
    "Battery Zigbee thermostat with dry contact for boiler control, Smart sprinkler timer, "
    "Smart sprinkler timer with measurements, Hose faucet water timer, Parkside smart watering timer, "
    "Smart watering kit, Stove guard for safe cooking, 2.5 Stove guard, Water walve, Smart water/gas valve, "
    "IOT remote control smart gas lock, Zigbee smart water valve with flow meter and temperature sensor"
)


@pytest.mark.parametrize("model", MODELS_THAT_ASK.split(", "))
def test_a_relay_asks_if_its_model_is_for_water_gas_boilers_or_stoves(model: str) -> None:
    """Relays of zigbee-herdsman-converters 26.112."""
    one = of_model(model, "switch", "on_off")
    assert f"the model {model!r} says " in why_it_asks(one, one.parts[0])
    assert not may(LOCAL_RIGHTS, one)


@pytest.mark.parametrize(
    "model",
    ["Zigbee 30A relay with NTC temperature sensors and water leak detection", "Pilot wire heating module", "Gateway"],
)
def test_a_relay_of_another_model_does_not_ask(model: str) -> None:
    one = of_model(model, "switch", "on_off")
    assert not always_asks(one, one.parts[0])


@pytest.mark.parametrize(
    ("one", "drives"),
    [
        (VALVE, WATER),
        (GARDEN, WATER),
        (device("Garden sprinkler", part("plug", "on_off")), WATER),
        (OVEN_PLUG, HEAT),
        (HALL_LOCK, frozenset({"lock"})),
        (GARAGE_COVER, frozenset({"entry"})),
        (HALL_LAMP, frozenset()),
        (TAGGED, frozenset()),
    ],
    ids=lambda one: one.id if isinstance(one, Device) else "",
)
def test_a_policy_can_ask_for_the_load_that_a_part_is_or_switches(one: Device, drives: Groups) -> None:
    found = {group for group in ALL_THAT_ASK if why_it_drives(one, one.parts[0], frozenset({group}))}
    assert found == drives


@pytest.mark.parametrize(
    ("name", "part_name", "tag", "asks"),
    [
        ("Garage", "", "", True),
        ("Garage left", "", "shutter", True),
        ("Shutters", "Garage", "", True),
        ("Garage", "Blind", "", False),
        ("Garage", "", "blind", False),
        ("Garage blind", "", "", False),
    ],
)
def test_a_cover_that_is_called_garage_is_its_door(name: str, part_name: str, tag: str, *, asks: bool) -> None:
    """As one of ESPHome or Home Assistant without class; the switch of that name is that of its lamp."""
    cover = device(name, part("window_covering", "movement", name=part_name, tag=tag))
    assert always_asks(cover, cover.parts[0]) is asks
    switch = device(name, part("switch", "on_off"))
    assert not always_asks(switch, switch.parts[0])


@pytest.mark.parametrize(
    ("name", "button", "asks"),
    [
        ("Garage", "Open", True),
        ("Door", "Release", True),
        ("Front door", "Open", True),
        ("Garage light", "Open", False),
        ("Kitchen", "Open", False),
        ("Garage", "Light", False),
    ],
)
def test_a_button_asks_by_the_name_of_its_device_and_its_own(name: str, button: str, *, asks: bool) -> None:
    """As the action ``open`` of a Thing called Garage, and the buttons of an ESPHome of that name."""
    one = device(name, part("generic_switch", "push", name=button))
    assert always_asks(one, one.parts[0]) is asks


@pytest.mark.parametrize("part_id", ["unlock_door", "door_unlock", "openDoor"])
@pytest.mark.parametrize("capability", ["text", "on_off"])
def test_a_setting_that_opens_asks(part_id: str, capability: str) -> None:
    """The easyiot ZB-ZL01 opens by a text, its password, and is no lock to Zigbee2MQTT."""
    one = device("0x1", part("x_setting", capability, part_id=part_id, category="config"))
    assert "'unlock'" in (why := why_it_asks(one, one.parts[0])) or "'open door'" in why
    assert not may(LOCAL_RIGHTS, one)


@pytest.mark.parametrize("name", ["Unlocked by", "Room name", "open_window", "Door open alarm", "Child lock"])
def test_another_text_or_flag_of_a_device_does_not(name: str) -> None:
    one = device("0x1", part("x_setting", "text", part_id=name), part("x_setting", "on_off", part_id=name))
    assert why_device_asks(one) == ""


@pytest.mark.parametrize(
    ("name", "most", "asks"),
    [("Boiler", 75.0, True), ("Boiler", 30.0, False), ("Boiler room", 75.0, False), ("Living room", 75.0, False)],
)
def test_a_thermostat_asks_if_it_is_called_a_boiler_and_becomes_hotter_than_a_room(
    name: str, most: float, *, asks: bool
) -> None:
    setpoint = Capability(name="heating_setpoint", settable=True, unit="°C", bounds=(30.0, most))
    one = device(name, part("thermostat", capabilities=(setpoint,)))
    assert always_asks(one, one.parts[0]) is asks


def test_a_boiler_without_bounds_asks() -> None:
    one = device("Boiler", part("thermostat", "heating_setpoint"))
    assert always_asks(one, one.parts[0])


@pytest.mark.parametrize(
    ("one", "reason"),
    [
        (HALL_LOCK, "its type is door_lock"),
        (OVEN, "it calls itself oven"),
        (ODD_LOCK, "its lock can be set"),
        (OVEN_PLUG, "the name 'Oven Plug' says 'oven'"),
        (GARDEN, "the model 'Zigbee smart water valve' says 'valve'"),
        (TAGGED, "it has the tag always_ask"),
        (HALL_LAMP, ""),
    ],
    ids=lambda one: one.id if isinstance(one, Device) else "",
)
def test_a_device_says_why_it_always_asks(one: Device, reason: str) -> None:
    assert why_device_asks(one) == why_it_asks(one, one.parts[0]) == reason


@pytest.mark.parametrize("service_type", ["light", "x_sensor", "x_setting", "thermostat", "fan"])
@pytest.mark.parametrize("name", ["Oven clock", "Garage door left", "Valve battery", "Gate motor 2", "Boiler 1"])
def test_only_relays_and_covers_ask_by_their_name(name: str, service_type: str) -> None:
    one = device(name, part(service_type, "on_off"))
    assert not always_asks(one, one.parts[0])


@pytest.mark.parametrize(
    ("model", "service_type"),
    [
        ("Thermostatic radiator valve", "thermostat"),
        ("Zigbee smart water valve", "x_setting"),
        ("1 gang touch panel switch with backlight and child lock", "switch"),
        ("Garage door opener", "light"),
        ("Smart garage door sensor", "x_setting"),
    ],
)
def test_a_part_that_does_not_drive_the_load_in_the_model_does_not_ask(model: str, service_type: str) -> None:
    one = of_model(model, service_type, "on_off")
    assert not always_asks(one, one.parts[0])


@pytest.mark.parametrize(
    "name", ["DHW setpoint", "dhw1 target", "Hot water target", "Water heater limit", "Boiler setpoint"]
)
def test_how_hot_the_water_becomes_asks(name: str) -> None:
    one = device("heat pump", part("x_setting", name=name, capabilities=(HOT_WATER,)))
    assert always_asks(one, one.parts[0])


@pytest.mark.parametrize("name", ["Flow target", "Water pressure", "Hot day limit"])
def test_another_temperature_does_not(name: str) -> None:
    one = device("heat pump", part("x_setting", name=name, capabilities=(HOT_WATER,)))
    assert not always_asks(one, one.parts[0])


@pytest.mark.parametrize(("most", "asks"), [(120.0, True), (100.0, True), (90.0, False), (35.0, False)])
def test_a_thermostat_asks_if_it_boils_water(most: float, *, asks: bool) -> None:
    setpoint = Capability(name="heating_setpoint", settable=True, bounds=(20.0, most))
    one = device("x", part("thermostat", capabilities=(setpoint,)))
    assert always_asks(one, one.parts[0]) is asks


def test_the_limit_of_a_radiator_valve_does_not_ask() -> None:
    assert not always_asks(RADIATOR, RADIATOR.parts[0])


@pytest.mark.parametrize("service_type", ["switch", "x_setting"])
def test_a_keypad_that_disarms_asks_with_all_that_it_has(service_type: str) -> None:
    """The WKE502Z arms by a switch, so that to turn it off disarms; whoever sets its code can do so later."""
    keypad = device(
        "keypad",
        part(service_type, "on_off", part_id="armed", name="Armed"),
        part("x_setting", "text", part_id="code", name="Admin code"),
    )
    assert [may(LOCAL_RIGHTS, keypad, number) for number in range(2)] == [False, False]
    assert not is_safe(keypad, keypad.parts[0], {"on_off": False})


@pytest.mark.parametrize(
    ("options", "asks"), [(("Disarmed", "Armed home"), True), (("arm", "disarm"), True), (("armed", "idle"), False)]
)
def test_a_choice_asks_if_it_disarms_an_alarm(options: tuple[str, ...], *, asks: bool) -> None:
    """As the select of a camera that has no alarm panel of its own."""
    choice = Capability(name="option", settable=True, options=options)
    camera = device("x", part("x_setting", capabilities=(choice,)))
    assert always_asks(camera, camera.parts[0]) is asks


def test_all_parts_of_a_garage_door_ask_but_for_its_lamp() -> None:
    """Its button opens it as well."""
    assert [may(LOCAL_RIGHTS, GARAGE, number) for number in range(3)] == [False, False, True]


def test_a_client_may_command_by_type_and_room() -> None:
    rights = read_scope(["act: light in hall"])
    assert [may(rights, one) for one in (HALL_LAMP, KITCHEN_LAMP, HALL_LOCK)] == [True, False, False]


@pytest.mark.parametrize(
    ("conventions", "may_command"),
    [(("tag",), False), (("owner", "tag"), True), (("tag", "homeassistant"), True), (("owner",), True), ((), True)],
)
def test_a_room_that_only_a_tag_says_gives_no_right(conventions: tuple[str, ...], *, may_command: bool) -> None:
    """Whoever can put up a tag can say a room; the owner's word and that of the device count as ever."""
    facts = tuple(
        Fact(name="area", value="Hall", gateway="", convention=one, key="", said_at=Time.from_seconds(0))
        for one in conventions
    )
    lamp = HALL_LAMP.model_copy(update={"facts": facts, "outer_areas": ("Ground floor",)})
    assert may(read_scope(["act: light in hall"]), lamp) is may_command
    assert may(read_scope(['act: in "ground floor"']), lamp) is may_command
    assert may(read_scope(["act: light"]), lamp)


def test_a_room_alone_holds_no_lock() -> None:
    """A lock has to be asked for by its type or its name."""
    rights = read_scope(["act: in hall"])
    assert [may(rights, one) for one in (HALL_LAMP, HALL_LOCK)] == [True, False]
    assert may(read_scope(["act: lock in hall"]), HALL_LOCK)
    assert not may(read_scope(["act: lock in kitchen"]), HALL_LOCK)


def test_a_type_that_is_asked_for_elsewhere_does_not_help_a_room() -> None:
    """The lock fits by its room, the word lock by the kitchen alone."""
    assert not may(read_scope(["act: in hall or (lamp and in kitchen)"]), HALL_LOCK)
    assert not may(read_scope(["act: not lamp"]), HALL_LOCK)


def test_several_queries_add_up() -> None:
    rights = read_scope(["act: light in hall", "act: lock"])
    assert [may(rights, one) for one in (HALL_LAMP, KITCHEN_LAMP, HALL_LOCK)] == [True, False, True]


def test_without_a_right_to_act_nothing_may_be_commanded() -> None:
    assert not may(read_scope(["read", "manage", "raw"]), HALL_LAMP)
    assert not may(ClientRights(), HALL_LAMP)


def test_a_scope_has_the_rights_that_it_lists() -> None:
    rights = read_scope([" read ", "act:light in hall", "raw"])
    assert [one for one in Right if rights.has(one)] == [Right.READ, Right.ACT, Right.RAW]
    assert (rights.text, ClientRights().text) == ("read, act, raw", "none")


@pytest.mark.parametrize(
    ("right", "problem"),
    [
        ("", "'' is no right; known are read"),
        ("raed", "'raed' is no right; did you mean read"),
        ("act", "'act': act needs a query, or all: 'act: light in hall'"),
        ("act:", "'act:': act needs a query"),
        ("read: light", "'read: light': read takes no query"),
        ("act: (light", "'act: (light': "),
        ("act: ligth in hall", "'act: ligth in hall': 'ligth' is neither a type nor a capability"),
        ("act: not (lamp or foo)", "'foo' is neither a type nor a capability"),
    ],
)
def test_an_invalid_right_is_refused_with_the_valid_ones(right: str, problem: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_scope(["read", right])
    assert problem in str(caught.value)
