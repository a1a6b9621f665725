"""Calls of services as steps of routines. Pure."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, pairwise
from typing import Final, NamedTuple, cast

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


def steps_of_service(automation: Automation, fields: UnreadFields, key: str) -> list[str | dict[str, object]]:
    """Return the steps of the call of a service, which the field *key* names: a scene, or an action of a device."""
    device_id = fields.texts_of("device_id")[:1] if key == "device_id" else []
    name = _service_name(fields, key)
    domain, data = name.partition(".")[0], fields.inner("data", "data_template", "service_data")
    if key == "device_id":
        given = {field: fields.take(field) for field in [*fields.left] if field in DEVICE_DATA}
        name, own = DEVICE_ACTIONS.get(name, (name, {}))
        data = UnreadFields(Located({**given, **{field: Located(value, 0) for field, value in own.items()}}, 0), "data")
    target = _target_of(fields, data)
    for entity in target.entities if key == "device_id" else ():
        automation.entities.find_of_device(entity, "".join(device_id), domain, "")
    for field in LEFT_OUT.get(name, ()):
        if data.take(field) is not None:
            automation.notes.append(f"`{field}` of {name} is left out")
    if name in DROPPED:
        data.left.clear()
        automation.notes.append(f"{name} is left out")
        return []
    if target.is_to_notify and (messages := message_steps(automation, name, data)) is not None:
        return [*messages]
    if (read := _APART.get(name)) is not None:
        return [*read(automation, name, data, target)]
    if name in _NEXT:
        is_cycle = data.flag("cycle", default=True)
        data.end()
        return [
            step
            for entity in _entities_of(automation, target, domain)
            for step in _next(automation, name, entity, is_cycle=is_cycle)
        ]
    if name not in SERVICES:
        raise NotCarriedError(f"the service {name} has no counterpart in routines{ADVICE.get(domain, '')}")
    target.check(name)
    if name == "scene.turn_on" and (scenes := automation.names.scenes_of(target.entities)):
        over = data.duration("transition")
        data.end()
        return [f"scene {scene}{f', over {over}' if over else ''}" for scene in scenes]
    if name == "scene.turn_on" and data.duration("transition"):
        automation.notes.append("a scene of Home Assistant takes no transition from homebot")
    if domain in {"alarm_control_panel", "lock"} and data.take("code") is not None:
        automation.notes.append(
            "a code is kept by no routine: write it in Home Assistant as the default code of the entity"
        )
    settings, over = [*settings_of(automation, name, data)], data.duration("transition") if domain == "light" else ""
    data.end()
    if any(word.words[:1] == "-" or str(word.value)[:1] == "-" for word in settings) and domain == "light":
        automation.notes.append("a lamp stays on at 1 % where a step would turn it off in Home Assistant")
    if (target.entities == ["all"] or target.areas) and _is_of_lights(name, settings, over):
        return [*_of_rooms(automation, target, settings)]
    known = _entities_of(automation, target, domain)
    return [text for entity in known for text in steps_of_entity(name, entity, settings, over)]


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


def _of_message(automation: Automation, _name: str, data: UnreadFields, _target: "_Target") -> Sequence[str]:
    return steps_of_message(automation, data)


_APART: Final[Mapping[str, Callable[[Automation, str, UnreadFields, "_Target"], Iterable[str]]]] = {
    **{f"automation.{way}": _of_routines for way in ("turn_on", "turn_off", "trigger")},
    "media_player.play_media": _of_media,
    "mqtt.publish": _of_message,
}
"""The readers of services that command no entity."""

_NEXT: Final = {
    f"{domain}.{service}"
    for domain in ("input_select", "select")
    for service in ("select_next", "select_previous", "select_first", "select_last")
} | {"media_player.media_play_pause", "cover.toggle"}
"""Services with an effect that depends on the state of their entity."""


def _next(
    automation: Automation, name: str, entity: KnownEntity, *, is_cycle: bool
) -> Sequence[str | dict[str, object]]:
    """Return the steps to the next state of an entity: a choice by the state that it has."""
    if name == "media_player.media_play_pause":
        play, pause = (_by_words(entity, f"media_player.media_{way}") for way in ("play", "pause"))
        return [{"if": [state_text(entity, "playing", "state")], "do": pause, "else": play}]
    if name == "cover.toggle":
        automation.notes.append(f"{entity.id} closes if it stands half open")
        ways = {way: _by_words(entity, f"cover.{way}_cover") for way in ("open", "close")}
        ends: dict[str, object] = {
            "if": [state_text(entity, "closed", "state")],
            "do": ways["open"],
            "else": ways["close"],
        }
        if "stopped" not in entity.options("movement") or not entity.takes("movement"):
            return [ends]
        moving = " or ".join(f"({state_text(entity, state, 'state')})" for state in ("opening", "closing"))
        return [{"if": [moving], "do": _by_words(entity, "cover.stop_cover"), "else": [ends]}]
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
    return cast("list[str | dict[str, object]]", choice)


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


def _is_of_lights(name: str, settings: Sequence[ServiceSetting], over: str) -> bool:
    """Return whether a service only switches lights on or off, as homebot does with all of a room."""
    return name in {"light.turn_on", "light.turn_off"} and len(settings) == 1 and not over


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


def _service_name(fields: UnreadFields, key: str) -> str:
    if key == "device_id":
        fields.take(key)
        return f"{fields.text('domain')}.{fields.text('type')}"
    return "scene.turn_on" if key == "scene" else fields.text(key)


def _target_of(fields: UnreadFields, data: UnreadFields) -> _Target:
    """Return the target, which older texts have in the data or beside the service."""
    target = fields.inner("target")
    ids, *places = (
        [(kind, text) for place in (target, data, fields) for text in place.texts(kind)]
        for kind in ("entity_id", "area_id", "device_id", "label_id", "floor_id")
    )
    target.end()
    return _Target([*(text for _, text in ids), *fields.texts("scene")], [*chain(*places)])
