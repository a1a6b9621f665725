"""Reader of files of automations: each becomes one routine, or one for each id of its triggers, or is refused. Pure.

Source: Home Assistant core 2026.11, ``components/automation/config.py``; the keys of before 2024.10 count as well.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device import Device
from homebot.errors import ConfigError, UsageError
from homebot.integrations.homeassistant.automations.actions import Actions
from homebot.integrations.homeassistant.automations.conditions import NEVER, Conditions
from homebot.integrations.homeassistant.automations.entities import Entities, KnownEntity
from homebot.integrations.homeassistant.automations.fields import (
    NotCarriedError,
    fields_of,
    flag_of,
    is_enabled,
    items_of,
    number_of,
    shown,
    text_of,
    walk,
)
from homebot.integrations.homeassistant.automations.triggers import Triggers
from homebot.routines.imports import ImportedRoutines, Refusal
from homebot.routines.text import read_routines, routine_text
from homebot.support.located import Located

__all__ = ["HomeAssistantAutomations"]

_KEYS: Final = (
    *("alias", "id", "description", "initial_state", "mode", "max", "max_exceeded", "trace"),
    *("trigger", "triggers", "condition", "conditions", "action", "actions"),
)
_MODES: Final = frozenset({"single", "restart", "queued", "parallel"})

_MOST_RUNS: Final = 10.0
"""The default of ``max``, and the limit of routines."""

_Fields = Mapping[str, Located]


class _Part(NamedTuple):
    """The triggers of one id, or all of an automation."""

    trigger: str | None
    nodes: list[Located]


class HomeAssistantAutomations:
    """Reader of ``automations.yaml``, and of packages and configurations with a key ``automation``."""

    def read(self, document: Located, source: str, devices: Sequence[Device]) -> ImportedRoutines:
        """Return the routines of *document*; see :class:`homebot.routines.imports.AutomationReader`."""
        nodes = [*_automations(document)]
        if not nodes:
            raise UsageError(f"{source} has no automations")
        texts: list[str] = []
        refused: list[Refusal] = []
        names: set[str] = set()
        entities = Entities(devices)
        for node in nodes:
            name = _name_of(node)
            entities.used.clear()
            problems: list[NotCarriedError] = []
            tables = [*_tables(node, name, entities, problems)]
            written = [] if problems else _written(tables, names, node.line, source, entities, problems)
            texts += written
            problems += [] if written or problems else [NotCarriedError(node.line, "it would do nothing")]
            refused += [Refusal(one.line, name, str(one)) for one in {str(one): one for one in problems}.values()]
        return ImportedRoutines(tuple(texts), tuple(refused), len(nodes))


def _automations(document: Located) -> Iterator[Located]:
    if isinstance(document.value, dict) and not {"trigger", "triggers"} & document.value.keys():
        for key, value in document.value.items():
            if key.partition(" ")[0] == "automation":
                yield from items_of(value)
        return
    yield from document.value if isinstance(document.value, list) else items_of(document)


def _name_of(node: Located) -> str:
    fields = node.value if isinstance(node.value, dict) else {}
    name = next((str(fields[one].value) for one in ("alias", "id") if one in fields), "")
    return " ".join(name.split())[:80] or f"automation in line {node.line}"


def _tables(
    node: Located, name: str, entities: Entities, problems: list[NotCarriedError]
) -> Iterator[dict[str, object]]:
    """Yield the tables of the routines of an automation; what has no counterpart is added to *problems*."""
    try:
        fields = fields_of(node, "automation")
        for key, value in fields.items():
            if key not in _KEYS:
                problems.append(NotCarriedError(value.line, f"`{key}` has no counterpart in routines"))
        mode = _mode_of(fields)
        enabled = flag_of(fields["initial_state"], "initial_state") if "initial_state" in fields else True
        parts = [*_parts(fields)]
    except NotCarriedError as exc:
        problems.append(exc)
        return
    for part in parts:
        table = _table(part, fields, entities, mode, problems, is_split=len(parts) > 1)
        if table:
            named = f"{name} ({part.trigger})" if len(parts) > 1 else name
            more = ({"mode": mode} if mode != "single" else {}) | ({} if enabled else {"enabled": False})
            yield {"name": named, **table, **more}


def _mode_of(fields: _Fields) -> str:
    mode = text_of(fields["mode"], "mode") if "mode" in fields else "single"
    if mode not in _MODES:
        raise NotCarriedError(fields["mode"].line, f"mode: {mode!r}")
    if "max" in fields and mode in {"queued", "parallel"} and number_of(fields["max"], "max") != _MOST_RUNS:
        raise NotCarriedError(fields["max"].line, "max: routines have no such limit")
    return mode


def _parts(fields: _Fields) -> Iterator[_Part]:
    """Yield the triggers, apart by their ids if a condition asks for these."""
    by_id: dict[str, list[Located]] = {}
    for number, one in enumerate(_listed(fields, "trigger")):
        inner = fields_of(one, "trigger")
        if is_enabled(inner):
            by_id.setdefault(text_of(inner["id"], "id") if "id" in inner else str(number), []).append(one)
    if not any(_asks_for_trigger(one) for key in fields for one in walk(fields[key])):
        yield _Part(None, [one for some in by_id.values() for one in some])
        return
    yield from (_Part(name, nodes) for name, nodes in by_id.items())


def _asks_for_trigger(fields: _Fields) -> bool:
    return "condition" in fields and fields["condition"].value == "trigger"


def _listed(fields: _Fields, key: str) -> list[Located]:
    """Return the elements of the key in its old or new form."""
    return [one for form in (key, f"{key}s") for one in items_of(fields.get(form))]


def _table(
    part: _Part, fields: _Fields, entities: Entities, mode: str, problems: list[NotCarriedError], *, is_split: bool
) -> dict[str, object]:
    """Return the keys ``when``, ``if`` and ``do``; empty if there are none, as for a trigger that does nothing."""
    triggers, conditions = Triggers(entities), Conditions(entities, part.trigger)
    when: list[str] = []
    held = []
    for one in part.nodes:
        try:
            when += triggers.read(one)
        except NotCarriedError as exc:
            problems.append(exc)
    for one in _listed(fields, "condition"):
        try:
            held += conditions.all_of([one])
        except NotCarriedError as exc:
            problems.append(exc)
    started_by = triggers.states if len(triggers.states) == len(part.nodes) and mode != "queued" else []
    actions = Actions(entities, conditions, started_by, is_split=is_split)
    first, steps = actions.all_of(_listed(fields, "action"), mode, problems)
    held += first
    if NEVER in held or not steps or not when:
        return {}
    texts = [*dict.fromkeys(one.text for one in held)]
    return {"when": when, **({"if": texts} if texts else {}), "do": steps}


def _in_unit(entity: KnownEntity) -> str:
    """Return the unit in which homebot has a sensor: the one in Home Assistant may differ, and is not always known."""
    unit = CAPABILITIES.get(entity.capability, OWN).unit
    return f", in {unit}" if unit else ""


def _written(
    tables: Sequence[dict[str, object]],
    names: set[str],
    line: int,
    source: str,
    entities: Entities,
    problems: list[NotCarriedError],
) -> list[str]:
    """Return the texts of *tables*, which homebot accepts, with their source and the meaning of their entities."""
    known = "".join(
        f"# {one.id}: {' '.join(one.device.name.split())}{_in_unit(one)}\n" for one in entities.used.values()
    )
    texts: list[str] = []
    for table in tables:
        text = routine_text(table)
        try:
            (found,) = read_routines(text, source)
        except ConfigError as exc:
            problems.append(NotCarriedError(line, f"{exc.key.rpartition('.')[2]}: {exc.reason}"))
            continue
        if found.app in names:
            problems.append(NotCarriedError(line, f"another automation is called {shown(Located(found.name, line))}"))
        names.add(found.app)
        texts.append(f"# {' '.join(source.split())}, line {line}\n{known}{text}")
    return [] if problems else texts
