"""Commands in words: which devices and parts they reach, and what they answer; in virtual time."""

from collections.abc import Mapping

import anyio
import pytest
from tests.control.conftest import Home, ignore
from tests.control.policies.houses import make_device

from homebot.command_words.targets import _parts_called
from homebot.devices import DevicePart, KeyValue
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest, CommandDevicesResponse
from homebot.devices.gateway_messages import Command
from homebot.devices.names import COMMAND_DEVICES
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part

pytestmark = pytest.mark.virtual_time


async def command(
    home: Home, target: str, word: str = "set", values: Mapping[str, str] | None = None
) -> CommandDevicesResponse:
    """Ask the service, as a client does."""
    await anyio.sleep(0.01)  # of virtual time, in which the directory takes everything in
    client = home.app.create_client(CommandDevices, COMMAND_DEVICES)
    given = tuple(KeyValue(key=name, value=value) for name, value in (values or {}).items())
    return await client.call(CommandDevicesRequest(target=target, command=word, values=given), timeout=600)


def sent(home: Home) -> list[tuple[str, str, PlainValue]]:
    return sorted((one.key, one.capability, one.value.plain()) for one in home.commands)


async def test_a_query_reaches_all_that_fit_and_nothing_else(home: Home) -> None:
    for key, area in (("one", "hall"), ("two", "hall"), ("three", "attic")):
        home.put(key, "light", "on_off", area=area)
    home.put("plug", "plug", "on_off", area="hall")
    answer = await command(home, "light in hall", "on")
    assert (answer.success, answer.outcome) == (True, "confirmed")
    assert [one.name for one in answer.results] == ["One", "Two"]
    assert sent(home) == [("one", "on_off", True), ("two", "on_off", True)]


@pytest.mark.parametrize(
    ("target", "word", "asks"),
    [
        ("door", "unlock", {"Door": "it is a door lock"}),
        ("all devices", "on", {"Garage_Door": "the name 'Garage_Door' says 'garage door'"}),
        ("door", "lock", {}),  # safer
        ("lamp", "on", {}),
    ],
)
async def test_a_client_that_asks_its_person_sends_nothing_at_first_to_what_always_asks(
    home: Home, target: str, word: str, asks: dict[str, str]
) -> None:
    home.put("door", "door_lock", "lock", area="hall")
    for key, kind in ("lamp", "light"), ("garage_door", "switch"):
        home.put(key, kind, "on_off", area="hall")
    client = home.app.create_client(CommandDevices, COMMAND_DEVICES)
    asked = CommandDevicesRequest(
        target=target, command=word, issuer="client:anna", scope=("act: all",), unless_asks=True
    )
    await anyio.sleep(0.01)
    answer = await client.call(asked, timeout=600)
    assert {one.key: one.value for one in answer.asks} == asks
    assert bool(sent(home)) is not bool(asks)
    assert not (await client.call(asked.model_copy(update={"unless_asks": False}), timeout=600)).asks
    assert sent(home)


@pytest.mark.parametrize("target", ["everything", "Everything in hall", "all devices"])
async def test_everything_is_what_takes_the_command(home: Home, target: str) -> None:
    home.put("lamp", "light", "on_off", area="hall")
    home.put("blind", "window_covering", "position", area="hall")
    answer = await command(home, target, "off")
    assert ([one.name for one in answer.results], answer.success) == (["Lamp"], True)
    assert sent(home) == [("lamp", "on_off", False)]


@pytest.mark.parametrize(("states", "value"), [((True, False), False), ((False, False), True), ((None, True), False)])
async def test_toggle_turns_off_what_is_on_and_else_on(
    home: Home, states: tuple[bool | None, bool], *, value: bool
) -> None:
    for key, state in zip(("one", "two"), states, strict=True):
        home.put(key, "light", "on_off", area="hall")
        if state is not None:
            await home.report(key, "on_off", state)
    assert (await command(home, "light in hall", "Toggle")).success
    assert {told for _, _, told in sent(home)} <= {value}


async def test_toggle_of_an_unknown_state_sends_nothing(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    answer = await command(home, "lamp", "toggle")
    assert (answer.success, answer.message) == (False, "whether lamp is on is unknown; say on or off")
    assert sent(home) == []


@pytest.mark.parametrize(
    ("word", "levels"),
    [
        ("+10 %", (50.0, 10.0)),
        ("-10 %", (30.0, None)),
        ("on, +10 %", (50.0, 10.0)),
        ("level -100", (1.0, None)),
        ("Brighter", (60.0, 20.0)),
        ("darker by 5 %", (35.0, None)),
    ],
)
async def test_a_change_is_by_so_much_of_each(home: Home, word: str, levels: tuple[float, float | None]) -> None:
    """The second is off, which is 0 and gets no darker; the third has reported nothing."""
    for key, (is_on, level) in {"one": (True, 40.0), "two": (False, 70.0), "three": (None, None)}.items():
        home.put(key, "light", "on_off", "level", area="hall")
        if is_on is not None:
            await home.report(key, "on_off", is_on)
            await home.report(key, "level", level)
    answer = await command(home, "light in hall", word)
    told = {(key, capability): value for key, capability, value in sent(home)}
    assert {key: told.get((key, "level")) for key in ("one", "two")} == dict(zip(("one", "two"), levels, strict=True))
    assert not any(key == "three" for key, _ in told)
    assert [one.result.outcome for one in answer.results if one.device == "three"] == ["refused"]


@pytest.mark.parametrize("target", ["lamp", "Lamp", "LAMP"])
async def test_a_device_is_called_by_its_id_or_its_name(home: Home, target: str) -> None:
    home.put("lamp", "light", "on_off")
    home.put("lamplet", "light", "on_off")
    assert (await command(home, target, "on")).success
    assert sent(home) == [("lamp", "on_off", True)]


@pytest.mark.parametrize(
    ("words", "capability", "value"),
    [
        ("turn on", "on_off", True),
        ("Turn Off", "on_off", False),
        ("level 40", "level", 40.0),
        ("set level to 40 %", "level", 40.0),
        ("brightness 40", "level", 40.0),
    ],
)
async def test_a_command_may_have_several_words(home: Home, words: str, capability: str, value: PlainValue) -> None:
    home.put("lamp", "light", "on_off", "level")
    assert (await command(home, "lamp", words)).success
    assert sent(home) == [("lamp", capability, value)]


async def test_a_device_that_is_away_and_does_not_answer_is_said_to_be_away(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    home.behaviours["lamp"] = ignore
    home.gateway.devices.report_reachable("lamp", reachable=False)
    (result,) = (await command(home, "lamp", "on")).results
    assert result.result.text.startswith("no answer within 10 s; it is offline, according to memory")
    home.gateway.devices.report_reachable("lamp", reachable=True)
    (result,) = (await command(home, "lamp", "on")).results
    assert result.result.text == "no answer within 10 s"


@pytest.mark.parametrize("is_back", [True, False])
async def test_whether_it_is_away_is_told_as_it_is_in_the_end(home: Home, *, is_back: bool) -> None:
    home.put("lamp", "light", "on_off")
    home.gateway.devices.report_reachable("lamp", reachable=not is_back)
    await anyio.sleep(1)

    async def change(home: Home, _: Command) -> None:
        home.gateway.devices.report_reachable("lamp", reachable=is_back)

    home.behaviours["lamp"] = change
    (result,) = (await command(home, "lamp", "on")).results
    assert ("it is offline" in result.result.text) is not is_back


async def test_the_worst_outcome_is_that_of_all(home: Home) -> None:
    home.put("one", "light", "on_off")
    home.put("two", "light", "on_off")
    home.behaviours["two"] = ignore
    answer = await command(home, "light", "on")
    assert (answer.success, answer.outcome) == (False, "no_answer")
    assert [one.result.outcome for one in answer.results] == ["confirmed", "no_answer"]


@pytest.mark.parametrize(("kind", "capability"), [("x_scene", "scene"), ("x_setting", "push"), ("x_setting", "locate")])
async def test_what_is_only_pressed_or_called_needs_no_value(home: Home, kind: str, capability: str) -> None:
    home.gateway.devices.put(GatewayDevice("it", "It", (simple_part(kind, settable=(capability,)),)), "it is there")
    answer = await command(home, "it", capability)
    assert answer.success, answer
    assert sent(home) == [("it", capability, True)]


@pytest.mark.parametrize(
    ("word", "values", "expected"),
    [
        ("on", {}, [("on_off", True)]),
        ("turn_off", {}, [("on_off", False)]),
        ("on", {"level": "40"}, [("level", 40.0)]),
        ("on", {"level": "40 %", "kelvin": "2700 K"}, [("color_temperature", 2700.0), ("level", 40.0)]),
        ("set", {"color": "120,80"}, [("color", (120.0, 80.0))]),
        ("set", {"color": "120, 80"}, [("color", (120.0, 80.0))]),
        ("on", {"color": "120 80"}, [("color", (120.0, 80.0))]),
        ("0.4", {}, [("level", 40.0)]),
        ("ON", {}, [("on_off", True)]),
        ("Turn_On", {"level": "40"}, [("level", 40.0)]),
        ("40%", {}, [("level", 40.0)]),
        ("40 %", {}, [("level", 40.0)]),
        ("0 %", {}, [("on_off", False)]),
        ("2700K", {}, [("color_temperature", 2700.0)]),
        ("2700 k", {}, [("color_temperature", 2700.0)]),
    ],
)
async def test_words_and_values_are_settings(
    home: Home, word: str, values: dict[str, str], expected: list[tuple[str, PlainValue]]
) -> None:
    home.put("lamp", "light", "on_off", "level", "color_temperature", "color")
    answer = await command(home, "lamp", word, values)
    assert answer.success, answer
    assert [(name, value) for _, name, value in sent(home)] == expected


@pytest.mark.parametrize(
    ("kind", "capability", "options", "word", "values", "expected"),
    [
        ("robotic_vacuum_cleaner", "vacuum", ("cleaning", "returning"), "start", {}, "cleaning"),
        ("robotic_vacuum_cleaner", "vacuum", ("cleaning", "returning"), "dock", {}, "returning"),
        ("robotic_vacuum_cleaner", "vacuum", ("cleaning", "returning"), "cleaning", {}, "cleaning"),
        ("x_lawn_mower", "mower", ("mowing", "paused", "docked"), "start", {}, "mowing"),
        ("x_lawn_mower", "mower", ("mowing", "paused", "docked"), "dock", {}, "docked"),
        ("fan", "fan_mode", ("auto", "sleep"), "set", {"mode": "sleep"}, "sleep"),
        ("fan", "fan_mode", ("auto", "Sleep"), "set", {"mode": "SLEEP"}, "Sleep"),
        ("robotic_vacuum_cleaner", "vacuum", ("cleaning", "returning"), "Dock", {}, "returning"),
        ("x_humidifier", "humidifier_mode", ("eco",), "set", {"mode": "eco"}, "eco"),
    ],
)
async def test_robots_take_words_and_mode_is_that_of_the_device(
    home: Home, kind: str, capability: str, options: tuple[str, ...], word: str, values: dict[str, str], expected: str
) -> None:
    home.put("device", kind, capability)
    part = simple_part(kind, settable=(capability,))
    taken = tuple(one.model_copy(update={"options": options}) for one in part.capabilities)
    part = part.model_copy(update={"capabilities": taken})
    home.gateway.devices.put(GatewayDevice("device", "Device", (part,)), "its options")
    answer = await command(home, "device", word, values)
    assert answer.success, answer
    assert sent(home) == [("device", capability, expected)]


@pytest.mark.parametrize("word", ["21 °C", "21°c", "21.0 C", "heating_setpoint 21 °C", "set heating_setpoint to 21°C"])
async def test_a_number_may_have_the_unit_that_the_list_of_devices_shows(home: Home, word: str) -> None:
    home.put("valve", "thermostat", "heating_setpoint")
    answer = await command(home, "valve", word)
    assert answer.success, answer
    assert sent(home) == [("valve", "heating_setpoint", 21.0)]


@pytest.mark.parametrize("word", ["70 F", "21 %", "heating_setpoint 70 °F"])
async def test_a_number_with_another_unit_is_refused(home: Home, word: str) -> None:
    home.put("valve", "thermostat", "heating_setpoint")
    answer = await command(home, "valve", word)
    assert (answer.success, answer.outcome) == (False, "refused")
    assert home.commands == []


@pytest.mark.parametrize(
    ("word", "values", "problem"),
    [
        ("banana", {}, "the word 'banana': this part takes on, off"),
        ("Banana", {}, "the word 'Banana': this part takes on, off"),
        ("140", {}, "the word '140': this part takes on, off, a number from 0 to 1 (0.4 for 40 %)"),
        ("140 %", {}, "the word '140 %': this part takes on, off"),
        ("40", {}, "the word '40': this part takes on, off, a number from 0 to 1 (0.4 for 40 %); did you mean 40 %?"),
        ("-5%", {}, "-5% of Lamp: by 5%? Its level is unknown; give a value, such as 5%"),
        ("level +10", {}, "level +10 of Lamp: by 10? Its level is unknown"),
        ("set", {"level": "+10 %"}, "by 10 %? Its level is unknown"),
        ("brighter", {}, "by 20 %? Its level is unknown"),
        ("on, +10 %", {}, "by 10 %? Its level is unknown"),
        ("on, off", {}, "on, off: these contradict each other"),
        ("on", {"level": "x"}, "'x' as level of Lamp: it takes a number in %"),
        ("on", {"level": "300"}, "300 as level of Lamp: it takes 0 to 100 %"),
        ("on", {"level": "40 lx"}, "'40 lx' as level of Lamp: "),
        ("set", {"on_off": "maybe"}, "it takes on or off"),
        ("set", {"position": "4"}, "position of Lamp: it has no such setting; it takes on_off, level"),
        ("on", {"color": "red"}, "color of Lamp: it has no such setting; it takes on_off, level"),
        ("level", {}, "level without a value: it takes 0 to 100 %"),
        ("brightness", {}, "brightness without a value: it takes 0 to 100 %"),
        ("on_off", {}, "on_off without a value: it takes on or off"),
        ("set", {}, "set without values: give one, such as level 40"),
        ("off", {"level": "50"}, "off with level 50: these contradict each other; give one of them"),
        ("on", {"level": "0"}, "on with level 0: these contradict each other"),
        ("off", {"color_temperature": "2700"}, "off with color_temperature 2700: these contradict each other"),
    ],
)
async def test_what_makes_no_sense_is_refused_and_not_sent(
    home: Home, word: str, values: dict[str, str], problem: str
) -> None:
    home.put("lamp", "light", "on_off", "level", *(["color_temperature"] if "color_temperature" in values else []))
    answer = await command(home, "lamp", word, values)
    (one,) = answer.results
    assert (answer.success, answer.outcome, one.result.policy) == (False, "refused", "device")
    assert problem in one.result.text
    assert answer.message == f"Lamp: {one.result.text}"
    assert home.commands == []


async def test_a_sensor_says_that_it_takes_no_commands(home: Home) -> None:
    """It was "Window Battery: the word 'on': this part takes nothing"."""
    battery = simple_part("x_sensor", readable=("battery",)).model_copy(update={"id": "b", "name": "Battery"})
    contact = simple_part("contact_sensor", readable=("contact",)).model_copy(update={"id": "c", "name": "Contact"})
    home.gateway.devices.put(GatewayDevice("window", "Window", (battery, contact)), "the test says so")
    answer = await command(home, "window", "on")
    assert answer.message == "Window: refused (device): the word 'on': it takes no commands; it only reports"


COLOR = "it takes hue (0 to 360) and saturation (0 to 100), such as 0,100 for red or 240,50 for pale blue"


@pytest.mark.parametrize(
    ("word", "values", "problem"),
    [
        ("on", {"color": "reddish"}, f"'reddish' as color of Lamp: {COLOR}"),
        ("on", {"color": "120"}, f"'120' as color of Lamp: {COLOR}"),
        ("on", {"color": "120,x,80"}, f"'120,x,80' as color of Lamp: {COLOR}"),
        ("color", {}, f"color without a value: {COLOR}"),
    ],
)
async def test_what_is_no_colour_is_refused_with_an_example(
    home: Home, word: str, values: dict[str, str], problem: str
) -> None:
    home.put("lamp", "light", "on_off", "color")
    answer = await command(home, "lamp", word, values)
    assert answer.message == f"Lamp: refused (device): {problem}"
    assert home.commands == []


@pytest.mark.parametrize(
    ("target", "problem"),
    [
        ("", "give the id or the name of a device"),
        ("lmp", "no device fits 'lmp'; did you mean Lamp?"),
        ("bog twin", "no device fits 'bog twin'; did you mean "),
        ("kettle", "no device fits 'kettle'; `homebot find` shows what does"),
        ("lmap", "no device fits 'lmap'; did you mean Lamp?"),
        ("light lmap", "no device fits 'light lmap'; did you mean Lamp?"),
        ("big twin", "2 devices are called big twin; give the id of one: "),
        ("lamp#left", "lamp has no part left"),
        ("Lamp#left", "lamp has no part left"),
        ("light in (", ""),
    ],
)
async def test_a_target_that_is_none_or_several_is_told(home: Home, target: str, problem: str) -> None:
    home.put("lamp", "light", "on_off")
    home.put("twin1", "light", "on_off", name="Big twin")
    home.put("twin2", "light", "on_off", name="Big Twin")
    answer = await command(home, target, "on")
    assert not answer.success
    assert answer.results == ()
    assert problem in answer.message
    assert answer.message
    assert home.commands == []


@pytest.mark.parametrize("target", ["light hall", "lights hall", "hall"])
async def test_a_name_that_is_a_typo_away_is_not_commanded_along(home: Home, target: str) -> None:
    home.put("hall", "light", "on_off")
    home.put("hill", "light", "on_off")
    assert (await command(home, target, "on")).success
    assert sent(home) == [("hall", "on_off", True)]


async def test_a_word_that_is_a_capability_too_is_a_word_where_no_value_is_given(home: Home) -> None:
    home.put("lock", "door_lock", "lock")
    await command(home, "lock", "lock")
    assert sent(home) == [("lock", "lock", "locked")]


async def test_a_sensor_refuses(home: Home) -> None:
    home.put("lux", "light_sensor", readable=("illuminance",))
    answer = await command(home, "lux", "on")
    assert (answer.success, answer.outcome) == (False, "refused")


async def test_an_appliance_is_turned_on_without_its_functions(home: Home) -> None:
    """Faikin announces an air conditioner with switches for its powerful mode and its display."""
    cooler = simple_part("room_air_conditioner", settable=("on_off",)).model_copy(update={"id": "ac"})
    switches = [
        simple_part("switch", settable=("on_off",)).model_copy(update={"id": name, "name": name.title()})
        for name in ("powerful", "display")
    ]
    home.gateway.devices.put(GatewayDevice("ac", "Guest room", (cooler, *switches)), "the test says so")
    home.behaviours["ac"] = ignore
    for target, expected in (
        ("Guest room", ["ac"]),
        ("guest_room#powerful", ["powerful"]),
        ("Powerful", ["powerful"]),
    ):
        answer = await command(home, target, "on")
        assert [one.part for one in answer.results] == expected


async def test_a_word_for_a_switch_is_no_text_for_its_label(home: Home) -> None:
    """Home Buttons announce texts, and others a time or the message of a notification, that are no configuration."""
    relay = simple_part("switch", settable=("on_off",)).model_copy(update={"id": "relay"})
    label = simple_part("x_setting", settable=("text",)).model_copy(update={"id": "label"})
    home.gateway.devices.put(GatewayDevice("panel", "Panel", (label, relay)), "the test says so")
    home.behaviours["panel"] = ignore
    for words, expected in ((("off", {}), ["relay"]), (("set", {"text": "off"}), ["label"])):
        answer = await command(home, "panel", *words)
        assert [one.part for one in answer.results] == expected


async def test_what_only_the_fan_can_is_not_for_its_lamp(home: Home) -> None:
    fan = simple_part("fan", settable=("on_off", "fan_speed")).model_copy(update={"id": "fan"})
    lamps = [simple_part("light", settable=("on_off",)).model_copy(update={"id": name}) for name in ("a", "b")]
    home.gateway.devices.put(GatewayDevice("unit", "Unit", (fan, *lamps)), "the test says so")
    home.behaviours["unit"] = ignore
    for words, parts in (
        (("set", {"fan_speed": "40"}), ["fan"]),
        (("on", {}), ["a", "b", "fan"]),
    ):
        answer = await command(home, "unit", *words)
        assert [one.part for one in answer.results] == parts
    answer = await command(home, "unit", "set", {"level": "40"})
    assert (answer.outcome, len(answer.results)) == ("refused", 3)


def put_relays(home: Home, key: str, names: Mapping[str, str]) -> None:
    parts = [
        simple_part("switch", settable=("on_off",)).model_copy(update={"id": part, "name": name})
        for part, name in names.items()
    ]
    home.gateway.devices.put(GatewayDevice(key, key.title(), tuple(parts)), "the test says so")
    home.behaviours[key] = ignore


@pytest.mark.parametrize(
    ("target", "parts"),
    [
        ("Heater", ["r4"]),
        ("garden tap", ["r3"]),
        ("Pump", ["r1"]),  # a type as well, of which there is none
        ("Garden light", ["r2"]),
        ("garden", ["r2", "r3"]),
        ("garden switch", ["r2", "r3"]),
        ("relays", ["r1", "r2", "r3", "r4"]),
        ("switch", ["r1", "r2", "r3", "r4"]),
    ],
)
async def test_one_of_several_relays_is_called_by_its_own_name(home: Home, target: str, parts: list[str]) -> None:
    put_relays(home, "relays", {"r1": "Pump", "r2": "Garden light", "r3": "Garden tap", "r4": "Heater"})
    answer = await command(home, target, "on")
    assert [one.part for one in answer.results] == parts


async def test_parts_of_several_devices_with_one_name_are_told_apart_by_their_ids(home: Home) -> None:
    put_relays(home, "one", {"r1": "Heater", "r2": "Lamp"})
    put_relays(home, "two", {"r1": "Heater"})
    answer = await command(home, "Heater", "on")
    assert (answer.success, answer.results) == (False, ())
    assert answer.message == "2 devices have a part called Heater; give the id of one: one#r1, two#r1"


async def test_relays_without_names_are_told_apart_by_their_ids(home: Home) -> None:
    put_relays(home, "relays", {"r1": "", "r2": ""})
    answer = await command(home, "relays", "on")
    assert [one.name for one in answer.results] == ["Relays #r1", "Relays #r2"]


def put_button(home: Home, key: str, name: str) -> None:
    button = simple_part("x_setting", settable=("push",)).model_copy(update={"id": "b", "name": name})
    home.gateway.devices.put(GatewayDevice(key, key.title(), (button,)), "the test says so")
    home.behaviours[key] = ignore


@pytest.mark.parametrize(
    ("target", "word", "parts"),
    [
        ("garage door", "press", ["box#b"]),
        ("garage door", "open", ["main#", "side#"]),
        ("garage door", "on", ["main#", "side#"]),  # neither can
        ("Light", "press", ["panel#b"]),
        ("Light", "off", ["fan#lamp", "lamp#"]),  # a name that says what it is means no other lamp less
    ],
)
async def test_a_part_whose_name_is_a_type_is_meant_where_nothing_of_the_type_takes_the_command(
    home: Home, target: str, word: str, parts: list[str]
) -> None:
    put_button(home, "box", "Garage door")
    put_button(home, "panel", "Light")
    for key in ("main", "side"):
        home.put(key, "closure", "position")
        home.behaviours[key] = ignore
    light = simple_part("light", settable=("on_off",)).model_copy(update={"id": "lamp", "name": "Light"})
    home.gateway.devices.put(GatewayDevice("fan", "Fan", (light,)), "the test says so")
    home.put("lamp", "light", "on_off")
    answer = await command(home, target, word)
    assert [f"{one.device}#{one.part}" for one in answer.results] == parts


async def test_a_device_whose_name_is_a_type_is_meant_alone(home: Home) -> None:
    home.put("it", "x_setting", "push", name="Pump")
    home.put("real", "pump", "on_off")
    assert (await command(home, "pump", "press")).success
    assert not (await command(home, "pump", "on")).success
    assert sent(home) == [("it", "push", True)]


async def test_of_several_parts_whose_name_is_a_type_none_is_chosen(home: Home) -> None:
    for key in ("one", "two"):
        put_button(home, key, "Garage door")
    home.put("main", "closure", "position")
    answer = await command(home, "Garage door", "press")
    assert (answer.success, answer.results) == (False, ())
    assert answer.message == "2 devices have a part called Garage door; give the id of one: one#b, two#b"


async def test_of_several_parts_of_one_name_the_only_one_that_takes_the_command_is_meant(home: Home) -> None:
    put_button(home, "panel", "Heater")
    put_relays(home, "relays", {"r1": "Heater", "r2": "Pump"})
    answer = await command(home, "Heater", "on")
    assert [one.part for one in answer.results] == ["r1"]


def kitchen_and_hall(home: Home) -> None:
    """A house of two rooms in which many a thing mentions its room."""
    for key, name, area in (
        ("hall_lamp", "Hall lamp", "Hall"),
        ("kitchen_lamp", "Kitchen lamp", "Kitchen"),
        ("worktop", "Worktop lamp", "Kitchen"),
    ):
        home.put(key, "light", "on_off", name=name, area=area)
    home.put("kettle", "plug", "on_off", name="Kettle", area="Kitchen")
    home.put("fan", "fan", "on_off", name="Fan", area="Kitchen")


@pytest.mark.parametrize(
    ("target", "reached"),
    [
        ("hall_lamp or kitchen_lamp", ["hall_lamp", "kitchen_lamp"]),
        ("the Hall lamp or the Kettle", ["hall_lamp", "kettle"]),
        ("the kitchen lamp", ["kitchen_lamp"]),
        ("lights in hall or lights in kitchen", ["hall_lamp", "kitchen_lamp", "worktop"]),
        ("lights in hall or fans in kitchen", ["fan", "hall_lamp"]),
        ("lights in hall or hall", ["hall_lamp"]),
        ("(lights in hall) or (kettle)", ["hall_lamp", "kettle"]),
        ("lights or mowers", ["hall_lamp", "kitchen_lamp", "worktop"]),
    ],
)
async def test_alternatives_are_commanded_if_they_mean_one_thing(home: Home, target: str, reached: list[str]) -> None:
    kitchen_and_hall(home)
    assert (await command(home, target, "on")).success
    assert [key for key, _, _ in sent(home)] == reached


@pytest.mark.parametrize(
    ("target", "asked"),
    [
        (
            "lights in hall or kitchen",
            "'lights in hall or kitchen' can mean 'lights in hall or lights in kitchen', which commands Hall lamp, "
            "Kitchen lamp, Worktop lamp, or '(lights in hall) or (kitchen)', which commands Fan, Hall lamp, Kettle, "
            "Kitchen lamp, Worktop lamp; give one of them",
        ),
        (
            "lights or fans in kitchen",
            "'lights or fans in kitchen' can mean 'lights in kitchen or fans in kitchen', which commands Fan, "
            "Kitchen lamp, Worktop lamp, or '(lights) or (fans in kitchen)', which commands Fan, Hall lamp, "
            "Kitchen lamp, Worktop lamp; give one of them",
        ),
        (
            "lights not in kitchen or kitchen",
            "'kitchen' in 'lights not in kitchen or kitchen' is not the name of a device; give names, or "
            "'(lights not in kitchen) or (kitchen)', which commands Fan, Hall lamp, Kettle, Kitchen lamp, Worktop lamp",
        ),
        ("hall lamp or kettel", "no device fits 'kettel'; did you mean Kettle?"),
        ("hall lamp or sprinkler", "'sprinkler' in 'hall lamp or sprinkler' is not the name of"),
        (
            "either hall lamp or kettle",
            "'either hall lamp' in 'either hall lamp or kettle' is not the name of a device",
        ),
        ("sink or sprinkler", "no device fits 'sink or sprinkler'; `homebot find` shows what does"),
        (
            "hall lamp and kettle",
            "no device fits 'hall lamp and kettle'; join devices with 'or': 'hall lamp or kettle', which commands "
            "Hall lamp, Kettle",
        ),
        (
            "lights, worktop",
            "'lights, worktop' can mean 'lights or worktop', which commands Hall lamp, Kitchen lamp, Worktop lamp, "
            "or what fits all of it, Worktop lamp; name the one you mean",
        ),
        ("a light in kitchen", "'a light in kitchen' could be Kitchen lamp, Worktop lamp; give the name of one"),
        ("that light", "no device fits 'that light'"),
    ],
)
async def test_alternatives_that_may_mean_more_are_asked_back(home: Home, target: str, asked: str) -> None:
    kitchen_and_hall(home)
    answer = await command(home, target, "off")
    assert not answer.success
    assert answer.message.startswith(asked)
    assert home.commands == []


async def test_each_reading_that_is_offered_is_carried_out(home: Home) -> None:
    kitchen_and_hall(home)
    assert (await command(home, "(lights in hall) or (kitchen)", "on")).success
    assert [key for key, _, _ in sent(home)] == ["fan", "hall_lamp", "kettle", "kitchen_lamp", "worktop"]


@pytest.mark.parametrize(
    ("target", "reached"),
    [
        ("lights 1", ["more", "one"]),
        ("attic 10 light", ["ten"]),
        ('"Lamp 1"', ["one"]),
        ('name="Lamp 1"', ["one"]),
        ("lights in attic 1", ["ten"]),
    ],
)
async def test_a_number_and_a_quoted_name_are_whole(home: Home, target: str, reached: list[str]) -> None:
    for key, name, area in (("one", "Lamp 1", "Attic"), ("ten", "Lamp 10", "Attic 1"), ("more", "Lamp 1 b", "Hall")):
        home.put(key, "light", "on_off", name=name, area=area)
    assert (await command(home, target, "on")).success
    assert [key for key, _, _ in sent(home)] == reached


async def test_an_option_is_for_the_setting_that_has_it(home: Home) -> None:
    """A television takes its source, and its other settings do not refuse it."""

    def select(name: str, *options: str) -> Part:
        option = Capability(name="option", options=options, settable=True)
        return Part(id=name, service_type="x_setting", name=name, capabilities=(option,))

    parts = (select("Source", "HDMI 1", "HDMI 2"), select("Sound", "Movie", "Music"))
    home.gateway.devices.put(GatewayDevice("tv", "TV", parts), "the test says so")
    home.behaviours["tv"] = ignore
    answer = await command(home, "TV", values={"option": "HDMI 2"})
    assert [one.part for one in answer.results] == ["Source"]
    answer = await command(home, "TV", values={"option": "Opera"})
    assert (answer.success, len(answer.results)) == (False, 2)


async def test_heating_means_the_thermostats_also_while_they_idle(home: Home) -> None:
    readable = ("thermostat_action",)
    home.put("heat", "thermostat", "heating_setpoint", readable=readable, name="Heater", area="Living")
    home.put("other", "thermostat", "heating_setpoint", name="Radiator", area="Hall")
    await home.report("heat", "thermostat_action", "idle")
    assert (await command(home, "heating in living", "22.5")).success
    assert sent(home) == [("heat", "heating_setpoint", 22.5)]


def named(part_id: str, name: str, *settable: str, kind: str = "switch") -> Part:
    return simple_part(kind, settable=settable or ("on_off",)).model_copy(update={"id": part_id, "name": name})


@pytest.mark.parametrize(
    ("target", "parts"),
    [
        ("Fountain", []),
        ("the fountain", []),
        ("fountain", ["a", "b"]),
        ("fountain#a", ["a"]),
        ("Pump", ["b"]),
        ("fountain pump", ["b"]),
        ("Fountain Fountain", ["a"]),
    ],
)
async def test_a_name_of_a_device_and_of_one_of_its_parts_asks_which_is_meant(
    home: Home, target: str, parts: list[str]
) -> None:
    device = GatewayDevice("fountain", "Fountain", (named("a", "Fountain"), named("b", "Pump")))
    home.gateway.devices.put(device, "the test says so")
    answer = await command(home, target, "on")
    assert [one.part for one in answer.results] == parts
    if not parts:
        assert answer.message == (
            f"{target.removeprefix('the ')!r} could be Fountain Fountain, Fountain Pump; "
            "give the id of one: fountain#a, fountain#b"
        )


async def test_a_name_that_a_device_shares_with_its_only_part_that_takes_the_command_is_no_question(
    home: Home,
) -> None:
    thermostat = named("a", "Hall", "heating_setpoint", kind="thermostat")
    home.gateway.devices.put(GatewayDevice("x", "Hall", (thermostat, named("b", "Boost"))), "the test says so")
    assert [one.part for one in (await command(home, "Hall", "21 °C")).results] == ["a"]


@pytest.mark.parametrize("name", ["Gen 1", "Gen 2", "gen 3"])
def test_of_announcements_with_one_identifier_a_name_reaches_the_part_that_bears_it(name: str) -> None:
    """It switched three relays."""
    names = ("Gen 1", "Gen 2", "Gen 3")
    parts = tuple(DevicePart(id=one, part=named(one, one), routes=()) for one in names)
    device = make_device("gen_1", "switch").model_copy(update={"name": "Gen 1", "names": names, "parts": parts})
    ((_, (part,)),) = _parts_called(CommandDevicesRequest(target=name, command="on"), device, name).targets
    assert part.id == name.capitalize()


@pytest.mark.parametrize("area", ["", "kitchen"])
async def test_words_that_fit_buttons_of_several_devices_press_none(home: Home, area: str) -> None:
    for key in ("hood", "heater"):
        button = named("stop", "Stop", "push", kind="x_setting")
        home.gateway.devices.put(GatewayDevice(key, f"Kitchen {key}", (button,), area=area), "the test says so")
    answer = await command(home, "kitchen stop", "press")
    assert answer.message == "'kitchen stop' could be Kitchen heater, Kitchen hood; give the name of one, or a type"
    assert sent(home) == []
    assert (await command(home, "Kitchen hood", "press")).success


async def test_a_word_stops_what_can_be_stopped_and_presses_no_button_of_that_name(home: Home) -> None:
    stop = named("stop", "Stop", "push", kind="x_setting")
    blind = named("blind", "Blind", "movement", kind="window_covering")
    home.gateway.devices.put(GatewayDevice("blind", "Window", (blind, stop), area="kitchen"), "the test says so")
    home.gateway.devices.put(GatewayDevice("oven", "Radio", (stop,), area="kitchen"), "the test says so")
    answer = await command(home, "in kitchen", "stop")
    assert sent(home) == [("blind", "movement", "stopped")], answer
    assert (await command(home, "Radio", "stop")).success  # nothing else is meant
