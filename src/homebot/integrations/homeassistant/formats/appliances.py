"""Fans, humidifiers, sirens, and robots that clean or mow. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt``: fan.py, humidifier.py, lawn_mower.py, siren.py, vacuum.py; the
segments of a vacuum: 2026.9.
"""

from collections.abc import Callable, Mapping
from itertools import islice

from homebot.conventions.command_values import bool_writer, option_writer, percent_writer, speed_of
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.payload import (
    Readings,
    as_fields,
    clean_text,
    compact_json,
    fields_of,
    meaning_reader,
    number_of,
    shown,
    unreadable,
    whole_of,
)
from homebot.conventions.units import percent_grid
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.homeassistant.formats.components import (
    MOWER_ACTIONS,
    MOWER_STATES,
    VACUUM_ACTIONS,
    VACUUM_STATES,
)
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity, Scale
from homebot.integrations.homeassistant.formats.topics import CommandTopic, ValueSource
from homebot.support.folding import fold

_MAX_MODE_CHARACTERS = 120
_DIRECTIONS = ("forward", "reverse")
_EMPTY_PAYLOADS = (b"", b"None")
_MAX_SEGMENTS = 300
_VACUUM_FEATURES = ("start", "stop", "return_home", "battery", "clean_spot")


def build_fan(config: DiscoveryConfig) -> DescribedPart:
    """Describe a fan."""
    entity = Entity(config, "fan")
    payloads = config.on_off_payloads()
    states = {payloads[False]: False, payloads[True]: True, "None": None}
    entity.add_flag(
        "on_off", config.source("state_topic", "state_value_template"), config.required_command(), payloads, states
    )
    _add_speed(entity, config)
    _add_modes(entity, config, "preset_mode", "preset_mode", config.value_source("preset_mode"))
    payloads = {
        True: config.text("payload_oscillation_on", "oscillate_on"),
        False: config.text("payload_oscillation_off", "oscillate_off"),
    }
    entity.add_flag(
        "oscillation",
        config.value_source("oscillation"),
        config.command_of("oscillation"),
        payloads,
        {payloads[False]: False, payloads[True]: True},
    )
    command = config.command_of("direction")
    read = meaning_reader("direction", {direction: direction for direction in _DIRECTIONS})
    writer = option_writer("direction", _DIRECTIONS, command.publish) if command else None
    entity.add_value("direction", config.value_source("direction"), read, command, writer)
    return entity.build()


def _add_speed(entity: Entity, config: DiscoveryConfig) -> None:
    least = config.integer("speed_range_min", 1, least=1)
    most = config.integer("speed_range_max", 100, least=1)
    if least >= most:
        raise WireError(f"{config.component}: speed_range_max is {most}, not above speed_range_min {least}")
    scale = Scale(least - 1, most)
    unknown = config.text("payload_reset_percentage", "None")
    command = config.command_of("percentage")
    expected = f"a whole number from {least - 1} to {most}"

    def read(text: str) -> Readings:
        if text == unknown:
            return {"fan_speed": None}
        speed = whole_of(text)
        percent = -1.0 if speed is None else scale.percent(speed)
        return {"fan_speed": percent} if 0 <= percent <= 100 else unreadable(text, expected)

    def publish(percent: float) -> Publications:
        return command.publish(scale.zero + speed_of(percent, scale.full - scale.zero)) if command else ()

    writer = percent_writer("fan_speed", publish) if command else None
    entity.add_value(
        "fan_speed",
        config.value_source("percentage"),
        read,
        command,
        writer,
        grid=percent_grid(scale.full - scale.zero),
    )


def _add_modes(entity: Entity, config: DiscoveryConfig, capability: str, name: str, source: ValueSource | None) -> None:
    """Add the modes in the field ``<name>s``, one of which is commanded by the fields of *name*."""
    modes, unknown = config.options(f"{name}s"), config.text(f"payload_reset_{name}", "None")
    if unknown in modes:
        raise WireError(f"{config.component}: {name}s has {shown(unknown)}, which means that the mode is unknown")
    entity.add_choice(capability, source, config.command_of(name), modes, {unknown: None})


def build_humidifier(config: DiscoveryConfig) -> DescribedPart:
    """Describe a humidifier or, by its tag, a dehumidifier."""
    entity = Entity(config, "x_humidifier", config.device_class or "humidifier")
    source = config.source("state_topic", "state_value_template")
    entity.add_flag("on_off", source, config.required_command(), config.on_off_payloads())
    least, most = config.number("min_humidity", 0.0), config.number("max_humidity", 100.0)
    if not 0 <= least < most <= 100:
        raise WireError(f"humidifier: max_humidity is {most:g}, not above min_humidity {least:g} and at most 100")
    unknown = config.text("payload_reset_humidity", "None")
    entity.add_number(
        "humidity_setpoint",
        config.source("target_humidity_state_topic", "target_humidity_state_template"),
        config.required_command("target_humidity_command_topic", "target_humidity_command_template"),
        bounds=(least, most),
        unit="%",
        unknown=unknown,
        from_device=_whole_within(least, most),
        to_device=int,
    )
    measured = config.source("current_humidity_topic", "current_humidity_template")
    entity.add_number("humidity", measured, None, unit="%", unknown=unknown, from_device=_whole_within(0, 100))
    source = config.source("mode_state_topic", "mode_state_template")
    _add_modes(entity, config, "humidifier_mode", "mode", source)
    return entity.build()


def _whole_within(least: float, most: float) -> Callable[[float], float | None]:
    def convert(number: float) -> float | None:
        whole = float(round(number))
        return whole if least <= whole <= most else None

    return convert


def build_siren(config: DiscoveryConfig) -> DescribedPart:
    """Describe a siren. Tone and volume also turn it on; without a template it is commanded in JSON."""
    on_command = config.required_command()
    off_command = config.required_command(template_key="command_off_template")
    if off_command.template is None:
        off_command = on_command
    payloads, states = config.on_off_payloads(), config.on_off_states()
    tones = config.options("available_tones")
    has_volume = config.flag("support_volume_set", default=True)

    def publish(on: bool = True, **fields: object) -> Publications:  # noqa: FBT001, FBT002 - a writer gives it by place
        command = on_command if on else off_command
        variables = {"state": payloads[on], **fields}
        if command.template is None:
            return command.publish(compact_json(variables))
        publication = command.publication(payloads[on], variables)
        if publication.payload in _EMPTY_PAYLOADS:
            raise RefusedError(f"a command on {command.topic}", "its template renders nothing for it")
        return (publication,)

    entity = Entity(config, "siren")
    readable = entity.read_text_from(
        config.source("state_topic", "state_value_template"),
        lambda text: _read_siren(text, states, tones, has_volume=has_volume),
    )
    entity.add_capability("on_off", readable=readable, writer=bool_writer("on_off", publish))
    if tones:
        writer = option_writer("siren_tone", tones, lambda tone: publish(tone=tone))
        entity.add_capability("siren_tone", readable=readable, writer=writer, options=tones)
    if has_volume:
        writer = percent_writer("volume", lambda percent: publish(volume_level=percent / 100))
        entity.add_capability("volume", readable=readable, writer=writer)
    entity.add_commands(on_command)
    return entity.build()


def _read_siren(text: str, states: Mapping[str, bool | None], tones: tuple[str, ...], *, has_volume: bool) -> Readings:
    if text in states:
        return {"on_off": states[text]}
    message = fields_of(text)
    readings: dict[str, PlainValue] = {}
    state, tone, volume = message.get("state"), message.get("tone"), number_of(message.get("volume_level"))
    if isinstance(state, str) and state in states:
        readings["on_off"] = states[state]
    else:
        unreadable(state if text.startswith("{") else text, states)
    if isinstance(tone, str) and tone in tones:
        readings["siren_tone"] = tone
    if has_volume and volume is not None and 0 <= volume <= 1:
        readings["volume"] = volume * 100
    return readings


def build_lawn_mower(config: DiscoveryConfig) -> DescribedPart:
    """Describe a robot that mows; each of its commands has a topic of its own."""
    commands = {
        state: (command, action)
        for state, (_, action) in MOWER_ACTIONS.items()
        if (command := config.command_of(action)) is not None
    }

    def read(text: str) -> Readings:
        if text.lower() == "none":
            return {"mower": None}
        return {"mower": text} if text in MOWER_STATES else unreadable(text, MOWER_STATES)

    def publish(state: str) -> Publications:
        command, action = commands[state]
        return command.publish(action)

    entity = Entity(config, "x_lawn_mower")
    source = config.source("activity_state_topic", "activity_value_template")
    writer = option_writer("mower", commands, publish) if commands else None
    entity.add_value("mower", source, read, None, writer, options=tuple(commands))
    entity.add_commands(*(command for command, _ in commands.values()))
    return entity.build()


def build_vacuum(config: DiscoveryConfig) -> DescribedPart:
    """Describe a robot that cleans, with the commands that its ``supported_features`` name."""
    features = frozenset(config.options("supported_features") if config.has("supported_features") else _VACUUM_FEATURES)
    command = config.command("command_topic", template_key="")
    set_speed = config.command("set_fan_speed_topic", template_key="")
    speeds = config.options("fan_speed_list") if "fan_speed" in features else ()
    clean_segments = config.command_of("clean_segments")
    segments: Mapping[str, str] = {}

    def read(text: str) -> Readings:
        nonlocal segments
        message = fields_of(text)
        segments = _segments_of(message) or segments
        speed, charge = message.get("fan_speed"), message.get("battery_level")
        state = message.get("state")
        readings: dict[str, PlainValue] = {}
        if "state" in message and (state is None or (isinstance(state, str) and state in VACUUM_STATES)):
            readings["vacuum"] = state
        else:
            unreadable(state if text.startswith("{") else text, VACUUM_STATES)
        if speeds and isinstance(speed, str):
            readings["fan_mode"] = clean_text(speed, _MAX_MODE_CHARACTERS)
        if "battery" in features and (percent := number_of(charge)) is not None:
            readings["battery"] = max(0.0, min(100.0, percent))
        return readings

    entity = Entity(config, "robotic_vacuum_cleaner")
    readable = entity.read_text_from(config.source("state_topic", template_key=""), read)
    payloads = {
        state: config.text(f"payload_{action}", action)
        for state, (_, action) in VACUUM_ACTIONS.items()
        if command is not None and action.replace("return_to_base", "return_home") in features
    }
    writer = None
    if command is not None and payloads:
        writer = option_writer("vacuum", payloads, lambda state: command.publish(payloads[state]))
    entity.add_capability("vacuum", readable=readable, writer=writer, options=tuple(payloads))
    if speeds:
        writer = option_writer("fan_mode", speeds, set_speed.publish) if set_speed else None
        entity.add_capability("fan_mode", readable=readable, writer=writer, options=speeds)
    entity.add_capability("battery", readable=readable and "battery" in features, unit="%")
    if "locate" in features and command:
        entity.add_push("locate", command, config.text("payload_locate", "locate"))
    if clean_segments is not None:
        publish = _segment_publisher(clean_segments)
        entity.remembers()
        entity.add_capability(
            "clean_rooms", readable=False, writer=lambda value, _transition: publish(_segment_ids(value, segments))
        )
    entity.add_commands(command, set_speed if speeds else None, clean_segments)
    return entity.build()


def _segments_of(message: Mapping[str, object]) -> Mapping[str, str]:
    """Return the names of the rooms in a state, by id; empty for none."""
    rooms = islice(as_fields(message.get("segments")).items(), _MAX_SEGMENTS)
    return {one: clean_text(str(name)) for one, name in rooms}


def _segment_ids(value: PlainValue, segments: Mapping[str, str]) -> list[str]:
    """Return the ids of the rooms *value*, which are named or numbered, with commas between them."""
    ids = {fold(word): one for one, name in segments.items() for word in (name, one)}
    wanted = [fold(word) for word in value.split(",")] if isinstance(value, str) else []
    if not wanted or not ids.keys() >= set(wanted):
        raise RefusedError("clean_rooms", f"it takes {', '.join(segments.values()) or 'rooms, but has told none yet'}")
    return list(dict.fromkeys(ids[word] for word in wanted))


def _segment_publisher(command: CommandTopic) -> Callable[[list[str]], Publications]:
    """Return the sender of ids: as a list in JSON, or as its template renders that list."""
    return lambda ids: command.publish(compact_json(ids) if command.template is None else ids)
