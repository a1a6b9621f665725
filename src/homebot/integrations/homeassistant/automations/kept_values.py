"""Values of an entity that an automation keeps in variables, and brings back later: as a snapshot of it. Pure."""

import re
from collections.abc import Mapping, Sequence
from itertools import takewhile
from typing import Final, NamedTuple

from homebot.integrations.homeassistant.automations.expressions import entity_value, expression_of
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, called_service, service_name, walk
from homebot.integrations.homeassistant.automations.service_tables import SERVICE_FIELDS
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes
from homebot.support.located import Located

_KEPT: Final[Mapping[tuple[str, str], str]] = {
    ("climate", ""): "hvac_mode",
    ("climate", "temperature"): "temperature",
    ("climate", "preset_mode"): "preset_mode",
    ("media_player", "volume_level"): "volume_level",
    ("cover", "current_position"): "position",
}
"""The fields with which a service sets the state of an entity of a domain, or an attribute."""

_SETS: Final[Mapping[str, frozenset[str]]] = {
    **{name: frozenset(fields) for name, fields in SERVICE_FIELDS.items()},
    "climate.turn_off": frozenset({"hvac_mode"}),
    **{f"cover.{name}": frozenset({"position"}) for name in ("open_cover", "close_cover")},
}
"""The fields that services set; one with several sets those in its data."""

_VARIABLE: Final = re.compile(r"\{\{ *(\w+) *(?:\| *(?:float|int) *)?\}\}")


class _Call(NamedTuple):
    """A call of a service that sets fields of one entity."""

    entity: str
    fields: frozenset[str]
    names: frozenset[str] = frozenset()


def with_snapshot(expressions: Mapping[str, str], actions: Sequence[Located]) -> tuple[str, list[Located]] | None:
    """Return an entity whose values *expressions* keep, and *actions* with one call of a scene that brings them back.

    The scene is ``scene.kept`` with the name of the entity. None unless all that *actions* set of it is brought back,
    by calls in a row.
    """
    kept = {name: known for name, text in expressions.items() if (known := _kept(text)) is not None}
    calls = [_restoring(action, kept) for action in actions]
    begin = next((place for place, call in enumerate(calls) if call is not None), len(calls))
    entities = {call.entity for call in calls[begin : begin + 1] if call is not None}
    restored = [*takewhile(lambda call: call is not None and call.entity in entities, calls[begin:])]
    end, own = begin + len(restored), [call for call in restored if call is not None]
    if not own or not _is_all(own, actions[:begin], actions[end:]):
        return None
    entity = own[0].entity
    scene = {"service": Located("scene.turn_on", 0), "entity_id": Located(f"scene.kept {entity}", 0)}
    return entity, [*actions[:begin], actions[begin]._replace(value=scene), *actions[end:]]


def _is_all(restored: Sequence[_Call], before: Sequence[Located], after: Sequence[Located]) -> bool:
    """Return whether *restored* bring back all that the actions before set of it, and nothing else takes its values."""
    fields = frozenset(field for call in restored for field in call.fields)
    names = [re.compile(rf"\b{name}\b") for call in restored for name in call.names]
    if any(name.search(str(other)) for name in names for other in (*before, *after)):
        return False
    calls = [inner for action in before for inner in walk(action) if service_name(inner)]
    calls = [call for call in calls if not service_name(call).startswith(("tts.", "notify."))]  # messages set nothing
    set_before = [_call_of(call) for call in calls if restored[0].entity in str(call)]
    return all(call is not None and call.fields <= fields for call in set_before)


def _kept(text: str) -> tuple[str, str] | None:
    """Return the entity, and the field that sets it, of the state or attribute that *text* is; None for none."""
    try:
        node = expression_of(text)
    except NotCarriedError:
        return None
    while isinstance(node, nodes.Filter) and node.name in {"float", "int"} and node.node is not None:
        node = node.node
    entity, attribute = entity_value(node)
    field = _KEPT.get((entity.partition(".")[0], attribute), "")
    return (entity, field) if field else None


def _call_of(fields: Mapping[str, Located]) -> _Call | None:
    """Return the call that *fields* are; None for another one, or of several entities."""
    try:
        call = called_service(fields)
    except NotCarriedError:
        return None
    known = _SETS.get(call.name, frozenset())
    set_fields = known & call.data.left.keys() if len(known) > 1 else known
    return _Call(call.entities[0], set_fields) if len(call.entities) == 1 and set_fields else None


def _restoring(action: Located, kept: Mapping[str, tuple[str, str]]) -> _Call | None:
    """Return the call with which *action* brings back *kept* values; None for another action."""
    fields = action.value if isinstance(action.value, dict) else {}
    call = _call_of(fields) if service_name(fields) and "enabled" not in fields else None
    if call is None:
        return None
    names = set()
    data = fields.get("data", Located({}, 0)).value
    given = {key: node.value for key, node in data.items() if key != "entity_id"} if isinstance(data, dict) else {}
    for key, value in given.items():
        found = _VARIABLE.fullmatch(value.strip()) if isinstance(value, str) else None
        if found is None or kept.get(found[1]) != (call.entity, key):
            return None
        names.add(found[1])
    return call._replace(names=frozenset(names)) if names and given.keys() == call.fields else None
