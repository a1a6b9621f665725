"""What a program outside may command, by the scope that the owner wrote."""

import pytest
from tests.devices.handles.conftest import device, part

from homebot.control.policies.rights import is_safe
from homebot.devices.always_ask import always_asks, why_device_asks, why_it_asks, why_it_drives
from homebot.devices.client_rights import ALL_RIGHTS, APP_RIGHTS, ClientRights
from homebot.devices.device import Device, DevicePart, Fact, KeyValue, Route
from homebot.devices.harmless import why_not_harmless
from homebot.devices.part import Capability
from homebot.devices.words import ALL_THAT_ASK, FIRE, WATER, Groups
from homebot.errors import UsageError
from homebot.messages import Time
from homebot.rights import Right
from homebot.words.rights import read_scope

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


def routed(one: DevicePart, convention: str) -> DevicePart:
    route = Route(gateway="mqtt", key=f"{convention}:{one.id}", part=one.id, convention=convention)
    return one.model_copy(update={"routes": (route,)})


def of_maker(maker: str, model: str, service_type: str) -> Device:
    one = device("front-lawn", part(service_type, "on_off"))
    facts = (KeyValue(key="manufacturer", value=maker), KeyValue(key="model", value=model))
    return one.model_copy(update={"metadata": facts})


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
    part = one.parts[number]
    is_harmless = not why_not_harmless(one, part)
    return rights.may_command(one, part, asks=always_asks(one, part), is_harmless=is_harmless)


@pytest.mark.parametrize("one", ASKING, ids=lambda one: one.id)
def test_a_device_that_lets_in_or_floods_or_burns_always_asks(one: Device) -> None:
    assert always_asks(one, one.parts[0])
    assert not may(APP_RIGHTS, one)
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
    "Infrared heater, Halogen heater 2, Quartz heater, Heat lamp, Infrarotheizung Bad, Terrassenstrahler, "
    "Gas shut-off, Water shutoff, Stopcock, Sump pump, Tauchpumpe, Chauffage infrarouge, Infraroodverwarming, "
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
    "Sproeier, Slagboom, Voordeur, Steam oven combi, Steam oven micro, Oven microwave, Dampfgarer-Kombi, Dialoggarer, "
    "Induktionskochfeld, Four vapeur, Four micro-ondes, Table de cuisson à induction, Piano cottura, Piano induzione, "
    "Placa de cocción, Placa de inducción, Stoomoven, Inductiekookplaat, Locked, Momentarily unlocked, Lock rule, "
    "Valve opened, Water supply, Lower oven cook mode, Homelink, Microwave, Mikrowelle Küche, Micro-ondes, Microonde, "
    "Microondas, Magnetron, CookTop, HausTür, WarmWasser"
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


OPENING_NAMES = """
en: Unlock, Alarm off, Oven on, Start sauna, Command UnlockDoor, Open gate, Remote start, Open trunk, Release strike
de: Tür entriegeln, Entsperren, Tor öffnen, Alarm unscharf, Alarm deaktivieren, Kofferraum öffnen, Tür Summer
fr: Déverrouiller la porte, Ouvrir le portail, Désarmer, Désactiver l'alarme, Ouvrir le coffre, Ouverture gâche
it: Sblocca porta, Apri cancello, Disarma, Disattiva allarme, Apri bagagliaio, Apri serratura
es: Desbloquear puertas, Abrir portón, Desarmar, Desactivar alarma, Abrir maletero, Abrir cerradura
nl: Ontgrendel deur, Open poort, Alarm uitschakelen, Kofferbak openen, Deur van slot, Deur opener
pl: Odblokuj drzwi, Otwórz bramę, Rozbrój, Wyłącz alarm, Otwórz bagażnik, Otwórz zamek
pt: Destrancar porta, Desbloquear, Abrir portão, Desarmar, Desativar alarme, Abrir mala, Abrir fechadura
sv: Lås upp, Öppna grind, Avlarma, Frånkoppla larm, Öppna bakluckan, Öppna låset
da: Lås døren op, Åbn port, Slå alarm fra, Åbn bagklap, Åbn lås
no: Lås opp døren, Åpne porten, Deaktiver alarm, Åpne bagasjerom
fi: Avaa ovi, Lukituksen avaus, Avaa portti, Poista hälytys, Avaa tavaratila, Avaa lukko
cs: Odemknout, Otevřít bránu, Deaktivovat alarm, Odjistit, Otevřít kufr, Otevřít zámek
sk: Odomknúť, Otvoriť bránu, Deaktivovať alarm, Otvoriť kufor, Otvoriť zámok
hu: Ajtó nyitása, Zár feloldás, Kapu nyitás, Riasztó hatástalanítása, Csomagtartó nyitása
ru: Разблокировать, Открыть ворота, Снять с охраны, Отключить охрану, Открыть багажник, Открыть замок
uk: Розблокувати, Відчинити ворота, Вимкнути охорону, Зняти з охорони, Відкрити багажник, Відкрити замок
zh: 解锁, 開鎖, 打开大门, 撤防, 警戒解除, 打开后备箱
ro: Deblochează ușa, Deschide poarta, Dezarmează, Dezactivează alarma, Deschide portbagaj, Deschide yala
tr: Kilidi aç, Bahçe kapısını aç, Alarmı devre dışı, Bagajı aç, Kapıyı aç
el: Ξεκλείδωμα, Άνοιγμα πόρτας, Αφόπλιση, Απενεργοποίηση συναγερμού, Άνοιγμα πορτ μπαγκάζ, Άνοιξε κλειδαριά
en: Trunk, Frunk, Tailgate, Liftgate
de: Alarm aus, Alarm ausschalten
fr: Hayon, Alarme désactivée
it: Bagagliaio, Spegni allarme
es: Maletero, Cajuela, Cerradero, Verja
nl: Kofferbak, Achterklep, Sluitplaat
pl: Bagażnik, Elektrozamek
pt: Bagageira, Porta-malas
sv: Bagagelucka, Frånkoppla
da: Bagklap, Bagagerum, Frakobl
no: Bagasjerom, Bagasjeluke
fi: Tavaratila, Takaluukku
cs: Kufr
sk: Kufor
hu: Csomagtartó, Feloldás
ru: Багажник, Электрозащёлка
uk: Багажник, Електрозамок
ro: Portbagaj
tr: Bagaj, Kapı otomatiği
el: Πορτ μπαγκάζ
"""  # noqa: RUF001


@pytest.mark.parametrize("line", OPENING_NAMES.strip().splitlines(), ids=lambda line: line[:2])
def test_a_button_that_unlocks_opens_or_disarms_asks_in_each_language(line: str) -> None:
    """Names made of the actions of locks, covers and alarm panels in Home Assistant core's translations."""
    names = line[4:].split(", ")
    buttons = [device("Wall 3", part("generic_switch", "push", name=name)) for name in names]
    assert [one.parts[0].part.name for one in buttons if may(APP_RIGHTS, one)] == []


@pytest.mark.parametrize(
    ("beside", "name", "tag", "asks"),
    [
        (part("window_covering", "position", name="Garage door"), "Light switch", "", True),
        (part("x_sensor", "measurement", name="Oven temperature"), "Power", "", True),
        (part("x_sensor", "measurement", name="Odometer"), "Horn", "", True),
        (part("x_sensor", "measurement", name="Odometer"), "Restart", "restart", False),
        (part("x_sensor", "measurement", name="Temperature"), "Power", "", False),
        (part("window_covering", "position", name="Bedroom blind"), "Power", "", False),
    ],
)
@pytest.mark.parametrize(
    ("kind", "capability"), [("generic_switch", "push"), ("switch", "on_off"), ("x_setting", "text")]
)
def test_what_stands_beside_a_garage_door_or_is_of_an_oven_or_a_car_asks(
    beside: DevicePart, name: str, tag: str, kind: str, capability: str, *, asks: bool
) -> None:
    beside = beside.model_copy(update={"id": "beside"})
    one = device("Box 7", part(kind, capability, name=name, part_id="own", tag=tag), beside)
    assert bool(why_it_asks(one, one.parts[0])) == asks


def choice(options: tuple[str, ...]) -> Capability:
    return Capability(name="option", settable=True, options=options)


def up_to(most: float, least: float = 30.0) -> Capability:
    return Capability(name="heating_setpoint", settable=True, unit="°C", bounds=(least, most))


PARTS: list[tuple[str, Device, bool]] = [
    # Who sets a contact opens what it is the contact of, as a Thing with a property `open` has it.
    ("contact that can be set", device("garage", part("contact_sensor", "contact")), True),
    # As Home Assistant calls an entity that is announced with the name null.
    ("text without a name", device("Unlock door", part("x_setting", "text")), True),
    ("text of another name", device("Unlock door", part("x_setting", "text", name="Volume")), False),
    ("choice without a name", device("Garage door", part("x_setting", "option")), True),
    ("choice with a name", device("Front gate", part("x_setting", "option", name="Sensitivity")), False),
    ("virtual button", device("shelly", part("generic_switch", "push", name="Open gate")), True),
    ("button of a garage", device("Garage door", part("x_setting", "push", name="Toggle")), True),
    ("boiler without bounds", device("Boiler", part("thermostat", "heating_setpoint")), True),
    ("radiator valve", RADIATOR, False),
    *(
        (f"button for care {more}", device("Garage door", part("x_setting", "push", name="Press", **more)), False)
        for more in ({"category": "config"}, {"tag": "restart"}, {"tag": "identify"})
    ),
    *(
        (f"{capability} {name}", device("yard", part("x_setting", capability, name=name, category="config")), asks)
        for capability in ("option", "state")
        for name, asks in (("Gate trigger", True), ("Main valve", True), ("Wasserventil", True), ("Keypad lock", False))
    ),
    # A cover that is called garage is its door, as one of ESPHome or Home Assistant without class.
    *(
        (f"cover {name} {own} {tag}", device(name, part("window_covering", "movement", name=own, tag=tag)), asks)
        for name, own, tag, asks in (
            ("Garage", "", "", True),
            ("Garage left", "", "shutter", True),
            ("Shutters", "Garage", "", True),
            ("Garage", "Blind", "", False),
            ("Garage", "", "blind", False),
            ("Garage blind", "", "", False),
        )
    ),
    # The key locks of Plugwise and EQ-3 in Home Assistant; a switch among settings still opens a valve.
    *(
        (f"setting {name}", device("anna", part("switch", "on_off", name=name, category="config")), asks)
        for name, asks in (("Lock", False), ("Kiosk lock", False), ("Main valve", True))
    ),
    *(
        (f"{kind} of IntelliFire", device("IntelliFire", part(kind, capability, name="Flame")), True)
        for kind, capability in (("switch", "on_off"), ("thermostat", "heating_setpoint"))
    ),
    # The switch of that name is that of its lamp.
    *((f"switch {name}", device(name, part("switch", "on_off")), False) for name in ("Garage", "Garage left")),
    # As the action `open` of a Thing called Garage, and the buttons of an ESPHome of that name.
    *(
        (f"button {button} of {name}", device(name, part("generic_switch", "push", name=button)), asks)
        for name, button, asks in (
            ("Garage", "Open", True),
            ("Door", "Release", True),
            ("Front door", "Open", True),
            ("Garage light", "Open", False),
            ("Tesla_BLE_5YJ3", "Open Trunk", True),  # tesla_ble_mqtt_core
            ("Tesla_BLE_5YJ3", "Flash Lights", False),
            ("Kitchen", "Open", False),
            ("Garage", "Light", False),
        )
    ),
    *(
        (f"{capability} {name}", device("0x1", part("x_setting", capability, part_id=name)), False)
        for name in ("Unlocked by", "Room name", "open_window", "Door open alarm", "Child lock")
        for capability in ("text", "on_off")
    ),
    # A boiler becomes hotter than a room, and a sauna or a grill boils water.
    *(
        (f"thermostat {name} to {most:g} °C", device(name, part("thermostat", capabilities=(up_to(most),))), asks)
        for name, most, asks in (
            ("Boiler", 75.0, True),
            ("Boiler", 30.0, False),
            ("Boiler room", 75.0, False),
            ("Living room", 75.0, False),
            ("x", 120.0, True),
            ("x", 100.0, True),
            ("x", 90.0, False),
            ("x", 35.0, False),
            ("Fireplace", 35.0, True),
            ("Pelletofen", 30.0, True),
            ("Stufa", 35.0, True),
            ("Fireplace room", 35.0, False),
        )
    ),
    *(
        (f"number {name}", device("heat pump", part("x_setting", name=name, capabilities=(HOT_WATER,))), asks)
        for names, asks in (
            (("DHW setpoint", "dhw1 target", "Hot water target", "Water heater limit", "Boiler setpoint"), True),
            (("DomesticHotWaterTemperatureSetpoint", "HwcTempDesired tempv"), True),  # of open3e and ebusd
            (("Extruder 1 temperature", "Bed temperature", "Nozzle target temperature"), True),  # OctoPrint, Bambu Lab
            (("Flow target", "Water pressure", "Hot day limit", "Bedroom temperature"), False),
        )
        for name in names
    ),
    *(
        (f"text {name}", device("BSB-LAN", part("x_setting", "text", name=name)), asks)
        for name, asks in (
            ("00-09 Trinkwasser - 1610 - Nennsollwert (°C)", True),
            ("00-08 Kessel - 2210 - Sollwert Minimum (°C)", True),
            ("00-05 Heizkreis 1 - 710 - Komfortsollwert (°C)", False),
            ("00-09 Trinkwasser - 1640 - Legionellenfunktion", False),
        )
    ),
    # Only relays and covers ask by their name.
    *(
        (f"{service_type} {name}", device(name, part(service_type, "on_off")), False)
        for service_type in ("light", "x_sensor", "x_setting", "thermostat", "fan")
        for name in ("Oven clock", "Garage door left", "Valve battery", "Gate motor 2", "Boiler 1")
    ),
    *(
        (f"{service_type} of {model}", of_model(model, service_type, "on_off"), False)
        for model, service_type in (
            ("Zigbee 30A relay with NTC temperature sensors and water leak detection", "switch"),
            ("Pilot wire heating module", "switch"),
            ("Gateway", "switch"),
            ("Thermostatic radiator valve", "thermostat"),
            ("Thermostatic radiator valve", "switch"),  # Yandex YNDX-00518
            ("Battery powered thermostat valve", "switch"),  # PushOk POK020
            ("Zigbee smart water valve", "x_setting"),
            ("1 gang touch panel switch with backlight and child lock", "switch"),
            ("Garage door opener", "light"),
            ("Smart garage door sensor", "x_setting"),
        )
    ),
    # Home Assistant calls the zones of irrigation by the names that they have in the maker's app.
    *(
        (f"{service_type} of {maker}", of_maker(maker, "GENERATION3_8ZONE", service_type), asks)
        for maker, service_type, asks in (
            ("Rachio", "switch", True),
            ("RainMachine", "switch", True),
            ("Rachio", "x_setting", False),
            ("Bosch", "switch", False),
        )
    ),
    # An oven heats by its program (hcpy); its language is a setting.
    *(
        (
            f"choice {category} of {name}",
            device(
                name, part("x_setting", name="ActiveProgram", category=category, capabilities=(choice(("Grill",)),))
            ),
            asks,
        )
        for name, category, asks in (("oven", "", True), ("oven", "config", False), ("dishwasher", "", False))
    ),
    # As the select of a camera that has no alarm panel of its own.
    *(
        (f"choice of {' or '.join(options)}", device("x", part("x_setting", capabilities=(choice(options),))), asks)
        for options, asks in (
            (("Disarmed", "Armed home"), True),
            (("arm", "disarm"), True),
            (("armed", "idle"), False),
        )
    ),
]


@pytest.mark.parametrize(("one", "asks"), [pytest.param(one, asks, id=name) for name, one, asks in PARTS])
def test_a_part_asks_by_its_type_its_name_or_its_model(one: Device, *, asks: bool) -> None:
    assert always_asks(one, one.parts[0]) is asks


def test_a_deed_without_a_name_is_called_by_its_id() -> None:
    """Many an action of a Thing has no title."""
    one = device("Porch", part("generic_switch", "push", part_id="unlockDoor"), part("light", "on_off", part_id="lamp"))
    assert [always_asks(one, each) for each in one.parts] == [True, False]


OTHER_NAMES = (
    "Heater, Towel heater, Kettle, Iron, Lüfter, Heizlüfter Lampe, "
    "Gate light, Lock monitor, Plug, Garage, Door, Door lamp, Garage light, Valve battery, Heizung Bad, "
    "Door bell garage, Garage door light, Garage heater left, Gate lamp 2, Valve amplifier, Front left, "
    "Navigate, Block heater, Child lock, Child lock 2, Clock, Gateway, Letter opener, Door sensor 1, EV charger, "
    "Door open alarm, Window open detection, Open, Toggle, Release, Door chime, Stop, Hot water pump, "
    "Cold water, Sauna light, Fireplace lamp, Boiler room fan, Boilerraum, Cooker hood, Garagentor Licht, "
    "Torbeleuchtung, Hauslicht, Ventilator, Motor, Monitor, Store, Kinderzimmer, Radiator, Lampe du portail, "
    "Sonnette portail, Porte, Lumière garage, Luce cancello, Luz puerta garaje, Poortlamp, Deurbel poort, "
    "Heater room lamp, Gas shut-off sensor, Auto shut-off, Infrared remote, Radiator booster, Pool pump, "
    "Sump pump alarm, Motion sensor microwave switch, Microwave light, Emergency stop, Shutdown, "
    "Puerta, Gas meter, Gas alarm, Front door light, Kamin Licht, Ofenraum Lampe, Schränke, Channel four"
)


@pytest.mark.parametrize("name", OTHER_NAMES.split(", "))
def test_a_plug_or_button_of_another_name_does_not(name: str) -> None:
    for one in (device(name, part("plug", "on_off")), device(name, part("x_setting", "push"))):
        assert not always_asks(one, one.parts[0])
        assert may(APP_RIGHTS, one)


MODELS_THAT_ASK = (
    "Hilo water heater controller, Calypso smart water heater controller, Water heater switch, "
    "Smart Boiler Switch, Boiler control relay module used in Enel Homix system, "
    "Dry contact switch for central heating boilers, "
    "Battery Zigbee thermostat with dry contact for boiler control, Smart sprinkler timer, "
    "Smart sprinkler timer with measurements, Hose faucet water timer, Parkside smart watering timer, "
    "Smart watering kit, Stove guard for safe cooking, 2.5 Stove guard, Water walve, Smart water/gas valve, "
    "KNYCKLAN electronic dishwasher shut-off unit, "
    "IOT remote control smart gas lock, Zigbee smart water valve with flow meter and temperature sensor"
)


@pytest.mark.parametrize("model", MODELS_THAT_ASK.split(", "))
def test_a_relay_asks_if_its_model_is_for_water_gas_boilers_or_stoves(model: str) -> None:
    """Relays of zigbee-herdsman-converters 26.112."""
    one = of_model(model, "switch", "on_off")
    assert f"the model {model!r} says " in why_it_asks(one, one.parts[0])
    assert not may(APP_RIGHTS, one)


@pytest.mark.parametrize(
    ("one", "drives"),
    [
        (VALVE, WATER),
        (GARDEN, WATER),
        (device("Garden sprinkler", part("plug", "on_off")), WATER),
        (OVEN_PLUG, frozenset({"heat"})),
        (device("Fireplace", part("plug", "on_off")), FIRE),
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


@pytest.mark.parametrize("part_id", ["unlock_door", "door_unlock", "openDoor"])
@pytest.mark.parametrize("capability", ["text", "on_off"])
def test_a_setting_that_opens_asks(part_id: str, capability: str) -> None:
    """The easyiot ZB-ZL01 opens by a text, its password, and is no lock to Zigbee2MQTT."""
    one = device("0x1", part("x_setting", capability, part_id=part_id, category="config"))
    assert "'unlock'" in (why := why_it_asks(one, one.parts[0])) or "'open door'" in why
    assert not may(APP_RIGHTS, one)


@pytest.mark.parametrize(
    ("one", "reason"),
    [
        (HALL_LOCK, "it is a door lock"),
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


@pytest.mark.parametrize("service_type", ["switch", "x_setting"])
def test_a_keypad_that_disarms_asks_with_all_that_it_has(service_type: str) -> None:
    """The WKE502Z arms by a switch, so that to turn it off disarms; whoever sets its code can do so later."""
    keypad = device(
        "keypad",
        part(service_type, "on_off", part_id="armed", name="Armed"),
        part("x_setting", "text", part_id="code", name="Admin code"),
    )
    assert [may(APP_RIGHTS, keypad, number) for number in range(2)] == [False, False]
    assert not is_safe(keypad, keypad.parts[0], {"on_off": False})


def test_what_only_tells_of_a_boiler_makes_no_thermostat_ask() -> None:
    """As the Emma of Plugwise, which reports boiler_water_temperature beside its room's thermostat."""
    water = part("temperature_sensor", part_id="boiler", capabilities=(Capability(name="temperature"),))
    emma = device("emma", water.model_copy(update={"advertised": "boiler_water_temperature"}), part("thermostat"))
    assert not why_device_asks(emma)


def test_all_parts_of_a_garage_door_ask_but_for_its_lamp() -> None:
    """Its button opens it as well."""
    assert [may(APP_RIGHTS, GARAGE, number) for number in range(3)] == [False, False, True]


def test_the_blinds_of_a_hub_with_a_garage_door_do_not_ask() -> None:
    """ESPSomfy-RTS announces all covers of a house as one device (SomfyShade::publishDisco)."""
    hub = device(
        "espsomfyrts",
        routed(part("window_covering", "movement", part_id="shade1", name="Salon", tag="shutter"), "homeassistant"),
        routed(part("closure", "movement", part_id="shade2", name="Garage", tag="garage_door"), "homeassistant"),
    )
    assert [may(APP_RIGHTS, hub, number) for number in range(2)] == [True, False]


def test_a_garage_door_that_another_program_takes_for_a_blind_asks_in_both_ways() -> None:
    """As a Shelly, of which only Home Assistant was told what its cover is."""
    shelly = device(
        "shelly",
        routed(part("window_covering", "movement", part_id="cover:0"), "shelly"),
        routed(part("closure", "movement", part_id="cover", tag="garage"), "homeassistant"),
    )
    assert [may(APP_RIGHTS, shelly, number) for number in range(2)] == [False, False]


@pytest.mark.parametrize("capability", ["push", "number", "text"])
def test_an_action_asks_by_its_name_also_if_it_takes_a_value(capability: str) -> None:
    """As openGate of a Web Thing, which takes the seconds after which the gate closes."""
    thing = device("entrance", part("generic_switch", capability, part_id="openGate"))
    assert not may(APP_RIGHTS, thing)


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
        ("", "'' is not a right; known are read"),
        ("raed", "'raed' is not a right; did you mean read"),
        ("act", "'act': act needs a query, or all: 'act: light in hall'"),
        ("act:", "'act:': act needs a query"),
        ("read: light", "'read: light': read takes no query"),
        ("robot: ro sie", "'robot: ro sie': node name 'ro sie' has a character"),
        ("robot: devices", "'robot: devices': robot 'devices' has the name of homebot's own topics"),
        ("act: (light", "'act: (light': "),
        ("act: ligth in hall", "'act: ligth in hall': 'ligth' is neither a type nor a capability"),
        ("act: not (lamp or foo)", "'foo' is neither a type nor a capability"),
    ],
)
def test_an_invalid_right_is_refused_with_the_valid_ones(right: str, problem: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_scope(["read", right])
    assert problem in str(caught.value)


def test_ask_gives_what_act_does_for_what_it_names_and_has_a_person_asked_for_all_that_fits() -> None:
    rights = read_scope(["read", "act: light", "ask: lock in hall", "ask: in kitchen"])
    assert may(rights, HALL_LOCK)
    assert may(rights, HALL_LAMP)
    asked = {one.id for one in (HALL_LOCK, HALL_LAMP, KITCHEN_LAMP, VALVE) if rights.must_ask(one, one.parts[0])}
    assert asked == {HALL_LOCK.id, KITCHEN_LAMP.id}
    assert not may(read_scope(["ask: in hall"]), HALL_LOCK)
    assert (rights.text, rights.act_scope) == ("read, act, ask", ("act: light", "ask: lock in hall", "ask: in kitchen"))
    assert all(may(read_scope(["ask: all"]), one) for one in (HALL_LOCK, VALVE, ALARM))
    with pytest.raises(UsageError, match="'ask: harmless': "):
        read_scope(["ask: harmless"])
