"""Reader of files of automations: each becomes one routine, or one for each id of its triggers, or is refused. Pure.

Source: Home Assistant core 2026.11, ``components/automation/config.py``; the keys of before 2024.10 count as well.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Final

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device import Device
from homebot.errors import ConfigError, UsageError
from homebot.integrations.homeassistant.automations.actions import Actions
from homebot.integrations.homeassistant.automations.automation import Automation
from homebot.integrations.homeassistant.automations.conditions import NEVER, conditions_of, texts_of
from homebot.integrations.homeassistant.automations.entities import Entities, KnownEntity
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields, items_of, walk
from homebot.integrations.homeassistant.automations.triggers import read_triggers
from homebot.routines.imports import ImportedRoutines, Refusal
from homebot.routines.text import read_routines, routine_text
from homebot.support.located import Located

_MODES: Final = frozenset({"single", "restart", "queued", "parallel"})
_USUAL: Final[Mapping[str, object]] = {"if": [], "mode": "single", "enabled": True}
_MAX_RUNS: Final = 10.0
"""The default of ``max``, and the limit of routines."""


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
            named = node.value if isinstance(node.value, dict) else {}
            alias = next((str(named[key].value) for key in ("alias", "id") if key in named), "")
            name = " ".join(alias.split())[:80] or f"automation in line {node.line}"
            entities.used.clear()
            whole = Automation(entities, [])
            with whole.in_line(node.line):
                tables = [*_tables(whole, UnreadFields(node, "automation"), name)]
                written = [] if whole.problems else _written(tables, names, f"{source}, line {node.line}", entities)
                texts += written
            refused += dict.fromkeys(Refusal(problem.line, name, str(problem)) for problem in whole.problems)
        return ImportedRoutines(tuple(texts), tuple(refused), len(nodes))


def _automations(document: Located) -> Iterator[Located]:
    if isinstance(document.value, dict) and not {"trigger", "triggers"} & document.value.keys():
        for key, value in document.value.items():
            if key.partition(" ")[0] == "automation":
                yield from [value] if value.tag else items_of(value, key)
        return
    yield from document.value if isinstance(document.value, list) else items_of(document, "automations")


def _tables(whole: Automation, fields: UnreadFields, name: str) -> Iterator[dict[str, object]]:
    """Yield the tables of the routines of an automation."""
    for key in ("id", "description", "trace", "max_exceeded"):
        fields.take(key)
    mode, most = fields.text("mode", "single"), fields.numbers("max")
    if mode not in _MODES:
        raise NotCarriedError(f"mode: {mode!r}")
    if mode in {"queued", "parallel"} and most not in ([], [_MAX_RUNS]):
        raise NotCarriedError("max: routines have no such limit")
    enabled = fields.flag("initial_state", default=True)
    triggers, conditions, actions = (fields.items(key, f"{key}s") for key in ("trigger", "condition", "action"))
    with whole.in_line(0):
        fields.end()
    parts = _parts([*conditions, *actions], triggers)
    for trigger, nodes in parts:
        part = Automation(whole.entities, whole.problems, trigger)
        reader = Actions(part, mode, is_split=len(parts) > 1)
        when = [text for texts in part.each(nodes, "trigger", partial(read_triggers, part)) for text in texts]
        if len(part.starts) != len(nodes):
            part.starts.clear()
        held = conditions_of(part, conditions)
        first, steps = reader.all_of(actions)
        held += first
        if NEVER in held or not steps or not when:  # it would never do anything
            continue
        table = {
            "name": f"{name} ({trigger})" if len(parts) > 1 else name,
            "when": [*dict.fromkeys(when)],
            "if": texts_of(held),
            "do": steps,
            "mode": mode,
            "enabled": enabled,
        }
        yield {key: value for key, value in table.items() if _USUAL.get(key) != value}


def _parts(asking: Sequence[Located], triggers: Sequence[Located]) -> list[tuple[str | None, list[Located]]]:
    """Return the triggers, apart by their ids if a condition asks for these."""
    if not any(
        "condition" in fields_inside and fields_inside["condition"].value == "trigger"
        for node in asking
        for fields_inside in walk(node)
    ):
        return [(None, [*triggers])]
    by_id: dict[str | None, list[Located]] = {}
    for number, trigger in enumerate(triggers):
        fields = UnreadFields(trigger, "trigger")
        if fields.flag("enabled", default=True):
            by_id.setdefault(fields.text("id", str(number)), []).append(trigger)
    return [*by_id.items()]


def _in_unit(entity: KnownEntity) -> str:
    """Return the unit in which homebot has a sensor: the one in Home Assistant may differ, and is not always known."""
    unit = CAPABILITIES.get(entity.capability, OWN).unit
    return f", in {unit}" if unit else ""


def _written(tables: Sequence[Mapping[str, object]], names: set[str], origin: str, entities: Entities) -> list[str]:
    """Return the texts of *tables*, which homebot accepts, with their origin and the meaning of their entities."""
    known = "".join(
        f"# {entity.id}: {' '.join(entity.device.name.split())}{_in_unit(entity)}\n"
        for entity in entities.used.values()
    )
    texts = [routine_text(table) for table in tables]
    try:
        routines = [read_routines(text, origin)[0] for text in texts]
    except ConfigError as exc:
        raise NotCarriedError(f"{exc.key.rpartition('.')[2]}: {exc.reason}") from exc
    if not routines:
        raise NotCarriedError("it would do nothing")
    for routine in routines:
        if routine.app in names:
            raise NotCarriedError(f"another automation is called {routine.name!r}")
        names.add(routine.app)
    return [f"# {' '.join(origin.split())}\n{known}{text}" for text in texts]
