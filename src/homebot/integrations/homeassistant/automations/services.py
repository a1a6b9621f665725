"""Calls of services as steps of routines. Pure."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, pairwise
from typing import Final, NamedTuple, TypeAlias, cast

from homebot.integrations.homeassistant.automations.entities import Automation, KnownEntity
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.published_commands import steps_of_message
from homebot.integrations.homeassistant.automations.service_messages import message_steps
from homebot.integrations.homeassistant.automations.service_settings import settings_of, step_text, steps_of_entity
from homebot.integrations.homeassistant.automations.service_tables import (
    ADVICE,
    DEVICE_ACTIONS,
    DEVICE_DATA,
    DROPPED,
    LEFT_OUT,
    SERVICE_WORDS,
    SERVICES,
    SETTINGS,
    SWITCHED,
    ServiceSetting,
)
from homebot.integrations.homeassistant.automations.states import state_text
from homebot.support.located import Located

Step: TypeAlias = str | dict[str, object]
"""A step of a routine, or a choice between some."""


def steps_of_service(automation: Automation, fields: UnreadFields, key: str) -> list[Step]:
    """Return the steps of the call of a service, which the field *key* names: a scene, or an action of a device."""
    name, data, target = (_action_of_device if key == "device_id" else _call)(automation, fields, key)
    for field in LEFT_OUT.get(name, ()):
        if data.take(field) is not None:
            automation.notes.append(f"`{field}` of {name} is left out")
    if name in DROPPED:
        data.left.clear()
        automation.notes.append(f"{name} is left out")
        return []
    if target.is_to_notify and (messages := message_steps(automation, name, data)) is not None:
        return [*messages]
    return [*_APART.get(name, _of_entities)(automation, name, data, target)]


def _call(_automation: Automation, fields: UnreadFields, key: str) -> tuple[str, UnreadFields, "_Target"]:
    """Read the name of a service, its data and its target."""
    name = "scene.turn_on" if key == "scene" else fields.text(key)
    data = fields.inner("data", "data_template", "service_data")
    return name, data, _target_of(fields, data)


def _action_of_device(automation: Automation, fields: UnreadFields, key: str) -> tuple[str, UnreadFields, "_Target"]:
    """Read the action of a device as the call of the service that does the same."""
    device_id = "".join(fields.texts(key)[:1])
    domain = fields.text("domain")
    action = f"{domain}.{fields.text('type')}"
    fields.inner("data", "data_template", "service_data")
    name, own = DEVICE_ACTIONS.get(action, (action, {}))
    given = {field: fields.take(field) for field in [*fields.left] if field in DEVICE_DATA}
    data = UnreadFields(Located({**given, **{field: Located(value, 0) for field, value in own.items()}}, 0), "data")
    target = _target_of(fields, data)
    for entity in target.entities:
        automation.entities.find_of_device(entity, device_id, domain, "")
    return name, data, target


def _of_entities(automation: Automation, name: str, data: UnreadFields, target: "_Target") -> Iterable[str]:
    """Return the steps that set the values of the service for each of its entities."""
    domain = name.partition(".")[0]
    if name not in SERVICES:
        raise NotCarriedError(f"the service {name} has no counterpart in routines{ADVICE.get(domain, '')}")
    target.check(name)
    if domain in {"alarm_control_panel", "lock"} and data.take("code") is not None:
        automation.notes.append(
            "a code is kept by no routine: write it in Home Assistant as the default code of the entity"
        )
    settings, over = [*settings_of(automation, name, data)], data.duration("transition") if domain == "light" else ""
    data.end()
    if domain == "light" and any("-" in {word.words[:1], str(word.value)[:1]} for word in settings):
        automation.notes.append("a lamp stays on at 1 % where a step would turn it off in Home Assistant")
    is_only_switch = name in {"light.turn_on", "light.turn_off"} and len(settings) == 1 and not over
    if is_only_switch and (target.entities == ["all"] or target.areas):
        return _of_rooms(automation, target, settings)
    known = _entities_of(automation, target, domain)
    return [text for entity in known for text in steps_of_entity(name, entity, settings, over)]


def _of_scenes(automation: Automation, name: str, data: UnreadFields, target: "_Target") -> Iterable[str]:
    """Return the steps that recall scenes of homebot, or of Home Assistant."""
    target.check(name)
    over = data.duration("transition")
    if scenes := automation.names.scenes_of(target.entities):
        data.end()
        return [f"scene {scene}{f', over {over}' if over else ''}" for scene in scenes]
    if over:
        automation.notes.append("a scene of Home Assistant takes no transition from homebot")
    return _of_entities(automation, name, data, target)


def _of_routines(automation: Automation, name: str, data: UnreadFields, target: "_Target") -> Iterator[str]:
    """Yield the steps that switch, or run, the routines of other automations."""
    stops = name == "automation.turn_off" and data.flag("stop_actions", default=True)
    data.take("stop_actions")
    if not data.flag("skip_condition", default=True):
        raise NotCarriedError("automation.trigger: `run routine` asks for no conditions; write them here as well")
    data.end()
    for entity in target.entities:
        if name == "automation.trigger":
            yield f"run routine {automation.routine_without_waits(entity)}"
        else:
            routine = automation.names.routine(entity)
            if stops and automation.waits(routine):
                automation.notes.append(f"a run of {routine} that waits goes on to its end")
            yield f"routine {routine} {name.rpartition('_')[2]}"


def _of_media(automation: Automation, name: str, data: UnreadFields, target: "_Target") -> Iterator[str]:
    """Yield the steps in which players play an address."""
    if data.take("extra") is not None:
        automation.notes.append(f"`extra` of {name} is left out")
    if data.text("enqueue", "play") not in {"play", "replace"}:
        raise NotCarriedError(f"{name}: `enqueue`; homebot has no queue of a player")
    words = ["announce"] if data.flag("announce", default=False) else []
    media = data.inner("media") if "media" in data else data
    address, kind = media.text("media_content_id"), media.text("media_content_type", "music")
    media.take("metadata")
    media.end()
    data.end()
    words += [address] if kind == "music" and " " not in address and not words else [kind, address]
    if " " in kind or "," in address:
        raise NotCarriedError(f"{name}: {address!r} cannot be written as a step")
    setting = ServiceSetting("media", value=" ".join(words))
    for entity in _entities_of(automation, target, "media_player"):
        yield from steps_of_entity(name, entity, [setting], "")


def _play_or_pause(_automation: Automation, entity: KnownEntity) -> list[Step]:
    play, pause = (_by_words(entity, f"media_player.media_{way}") for way in ("play", "pause"))
    return [{"if": [state_text(entity, "playing", "state")], "do": pause, "else": play}]


def _open_or_close(automation: Automation, entity: KnownEntity) -> list[Step]:
    automation.notes.append(f"{entity.id} closes if it stands half open")
    to_open, to_close = (_by_words(entity, f"cover.{way}_cover") for way in ("open", "close"))
    ends: Step = {"if": [state_text(entity, "closed", "state")], "do": to_open, "else": to_close}
    if "stopped" not in entity.options("movement") or not entity.takes("movement"):
        return [ends]
    moving = " or ".join(f"({state_text(entity, state, 'state')})" for state in ("opening", "closing"))
    return [{"if": [moving], "do": _by_words(entity, "cover.stop_cover"), "else": [ends]}]


_BY_STATE: Final = {"media_player.media_play_pause": _play_or_pause, "cover.toggle": _open_or_close}
"""The steps of services with an effect that depends on the state of their entity."""


def _of_next(automation: Automation, name: str, data: UnreadFields, target: "_Target") -> Iterator[Step]:
    """Yield the steps to the next state of each entity: a choice by the state that it has."""
    is_cycle = data.flag("cycle", default=True)
    data.end()
    for entity in _entities_of(automation, target, name.partition(".")[0]):
        read = _BY_STATE.get(name)
        yield from read(automation, entity) if read else _next_option(name, entity, is_cycle=is_cycle)


def _next_option(name: str, entity: KnownEntity, *, is_cycle: bool) -> Sequence[Step]:
    options = [*entity.options("option")]
    steps = {option: steps_of_entity("", entity, [SETTINGS["option"]._replace(value=option)], "") for option in options}
    if not options:
        raise NotCarriedError(f"{name}: homebot knows no options of {entity.id}")
    if name.endswith(("first", "last")):
        return steps[options[0 if name.endswith("first") else -1]]
    order = options if name.endswith("next") else options[::-1]
    choice: Sequence[object] = steps[order[0]] if is_cycle else []
    for option, following in reversed([*pairwise(order)]):
        step = {"if": [state_text(entity, option, "state")], "do": steps[following]}
        choice = [{**step, "else": [*choice]} if choice else step]
    return cast("list[Step]", choice)


_APART: Final[Mapping[str, Callable[[Automation, str, UnreadFields, "_Target"], Iterable[Step]]]] = {
    "scene.turn_on": _of_scenes,
    **{f"automation.{way}": _of_routines for way in ("turn_on", "turn_off", "trigger")},
    "media_player.play_media": _of_media,
    "mqtt.publish": lambda automation, _name, data, _target: steps_of_message(automation, data),
    **{
        f"{domain}.select_{way}": _of_next
        for domain in ("input_select", "select")
        for way in ("next", "previous", "first", "last")
    },
    **dict.fromkeys(_BY_STATE, _of_next),
}
"""The readers of services that set no value."""


def _by_words(entity: KnownEntity, service: str) -> list[str]:
    capabilities, _, text = SERVICE_WORDS[service].partition(" ")
    return steps_of_entity(service, entity, [ServiceSetting(capabilities, text)], "")


def _entities_of(automation: Automation, target: "_Target", domain: str) -> list[KnownEntity]:
    """Return the entities of *target*, which a service of *domain* commands."""
    entities = automation.entities
    ids = [entity for entity in target.entities if entity != "all" and not entities.members(entity)]
    members = [member for entity in target.entities for member in entities.members(entity)]
    ids += [member for member in members if domain in {member.partition(".")[0], "homeassistant"}]
    known = [*map(entities.find, ids)]
    if "all" in target.entities:
        automation.notes.append(f"all means each {domain} that homebot knows now")
        known += entities.of_domain(domain)
    for kind, place in target.places:
        automation.notes.append(f"{kind} {place} means the devices that homebot knows there now")
        domains = SWITCHED if domain == "homeassistant" else (domain,)
        known += entities.of_target(domains, kind, place)
    if others := [entity.id for entity in known if domain not in {entity.domain, "homeassistant"}]:
        raise NotCarriedError(f"a service of {domain}: {others[0]} belongs to another domain")
    return known


def _of_rooms(automation: Automation, target: "_Target", settings: Sequence[ServiceSetting]) -> Iterator[str]:
    """Yield the steps for the lights of rooms, or of the house."""
    if not target.areas:
        yield step_text("all lights", [settings[0].words])
    for room in map(automation.entities.room_of, target.areas):
        yield step_text(f"lights in {room}", [settings[0].words])


class _Target(NamedTuple):
    """The target of a service.

    Attributes:
        places: The fields of the target beside the entities, each with what it names.
    """

    entities: list[str]
    places: list[tuple[str, str]]

    @property
    def is_to_notify(self) -> bool:
        """True unless other entities than those that tell people something are named."""
        return all(
            entity.startswith(("notify.", "tts.", "media_player.", "assist_satellite.")) for entity in self.entities
        )

    @property
    def areas(self) -> list[str]:
        """The areas, if nothing else is named."""
        kinds = {kind for kind, _ in self.places}
        return [place for _, place in self.places] if kinds == {"area_id"} and not self.entities else []

    def check(self, name: str) -> None:
        """Refuse a target without a name."""
        if not self.entities and not self.places:
            raise NotCarriedError(f"{name}: no target; name an entity")


def _target_of(fields: UnreadFields, data: UnreadFields) -> _Target:
    """Return the target, which older texts have in the data or beside the service."""
    target = fields.inner("target")
    ids, *places = (
        [(kind, text) for place in (target, data, fields) for text in place.texts(kind)]
        for kind in ("entity_id", "area_id", "device_id", "label_id", "floor_id")
    )
    target.end()
    return _Target([*(text for _, text in ids), *fields.texts("scene")], [*chain(*places)])
