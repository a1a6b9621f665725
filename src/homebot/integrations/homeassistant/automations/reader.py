"""Reader of files of automations: each becomes one routine, or one for each id of its triggers, or is refused. Pure.

Source: Home Assistant core 2026.11, ``components/automation/config.py``, ``helpers/script.py`` and the services of its
domains; the keys of before 2024.10 count as well.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import Final, cast

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device import Device
from homebot.errors import ConfigError, UsageError
from homebot.integrations.homeassistant.automations.conditions import JOINTS, NEVER, Condition, conditions_of, texts_of
from homebot.integrations.homeassistant.automations.entities import Automation, Entities, KnownEntity
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields, items_of, walk
from homebot.integrations.homeassistant.automations.services import steps_of_service
from homebot.integrations.homeassistant.automations.states import state_of_template
from homebot.integrations.homeassistant.automations.triggers import read_triggers
from homebot.support.located import Located
from homebot.words.automations import ImportedRoutines, Refusal, RoutineCheck
from homebot.words.routine_text import routine_text
from homebot.words.steps import MAX_LINES, Do, Notify, read_step

Step = str | dict[str, object]
"""A step of a routine, or a choice between some."""

_CONDITIONS: Final = frozenset({"condition", *JOINTS})
_KINDS: Final = (
    *("service", "action", "scene", "delay", "wait_template", "wait_for_trigger", "choose", "if", "sequence"),
    *("repeat", "parallel", "variables", "stop", "event", "device_id", "set_conversation_response"),
)

_MAX_DIGITS: Final = 4


class Actions:
    """Reader of the actions of one automation.

    Args:
        is_split: Whether there are several routines of it, which must not wait.
        mode: The mode of the automation.
    """

    def __init__(self, automation: Automation, mode: str, *, is_split: bool) -> None:
        self._automation = automation
        self._mode = mode
        self._is_split = is_split
        self._has_waited = False

    def all_of(self, nodes: Sequence[Located]) -> tuple[list[Condition], list[Step]]:
        """Return the conditions of the automation that its actions begin with, and its steps.

        A new run ends the one before it, or waits for it, before its actions ask for anything.
        """
        first, steps = self._read(nodes)
        if first and self._has_waited and self._mode in {"restart", "queued"}:
            with self._automation.in_line(nodes[0].line):
                first, steps = [], _choice(first, steps, [])
        return first, steps

    def _read(self, nodes: Sequence[Located]) -> tuple[list[Condition], list[Step]]:
        """Return the conditions at the beginning, and the steps; conditions in the middle decide over the rest."""
        first: list[Condition] = []
        steps: list[Step] = []
        for number, node in enumerate(nodes):
            if isinstance(node.value, dict) and _CONDITIONS.isdisjoint(node.value):
                steps += [
                    step for node_steps in self._automation.each([node], "action", self._steps) for step in node_steps
                ]
                continue
            first_here = conditions_of(self._automation, [node])
            if not steps:
                first += first_here
                continue
            further, rest = self._read(nodes[number + 1 :])
            with self._automation.in_line(node.line):
                steps += _choice([*first_here, *further], rest, [])
            break
        return first, steps

    def _steps(self, fields: UnreadFields) -> Sequence[Step]:
        kind = fields.first_of(_KINDS)
        match kind:
            case "service" | "action" | "scene" | "device_id":
                return steps_of_service(self._automation.entities, fields, kind)
            case "delay":
                length = fields.duration("delay")
                self._pause()
                return [f"wait {length}"] if length else []
            case "wait_template" | "wait_for_trigger":
                most = fields.duration("timeout")
                if not most:
                    how = "write after how long to go on, such as `timeout: '01:00:00'`"
                    raise NotCarriedError(f"action {kind}: it may last forever; {how}")
                if not fields.flag("continue_on_timeout", default=True):
                    raise NotCarriedError(f"action {kind}: a routine goes on after the timeout")
                text = (
                    self._awaited(fields)
                    if kind == "wait_for_trigger"
                    else state_of_template(self._automation.entities, fields, kind)
                )
                self._pause()
                return [f"wait until {text}, at most {most}"]
            case "if":
                conditions = conditions_of(self._automation, fields.items("if"))
                return _choice(conditions, self._branch(fields.items("then")), self._branch(fields.items("else")))
            case "choose":
                default = self._branch(fields.items("default"))
                options = self._automation.each(fields.items("choose"), "choose", self._option)
                for conditions, steps in reversed(options):  # each is tried if those before it do not hold
                    default = _choice(conditions, steps, default)
                return default
            case "sequence":
                return self._branch(fields.items("sequence"))
            case "parallel":
                return self._parallel(fields)
            case "repeat":
                return self._repeated(fields.inner("repeat"))
            case "":
                fields.end()
        raise NotCarriedError(f"action: `{kind}` has no counterpart in routines")

    def _branch(self, nodes: Sequence[Located]) -> list[Step]:
        conditions, steps = self._read(nodes)
        return _choice(conditions, steps, [])

    def _option(self, fields: UnreadFields) -> tuple[list[Condition], list[Step]]:
        conditions = conditions_of(self._automation, fields.items("conditions"))
        nodes = fields.items("sequence")
        return conditions, [] if NEVER in conditions else self._branch(nodes)

    def _parallel(self, fields: UnreadFields) -> list[Step]:
        """Read simultaneous actions: commands to different devices may be given in a row."""
        branches = [self._branch([node]) for node in fields.items("parallel")]
        reached: list[str] = []
        for branch in branches:
            steps = [read_step(text) if isinstance(text, str) else None for text in branch]
            targets = {step.target for step in steps if isinstance(step, Do)}
            if not all(isinstance(step, Do | Notify) for step in steps) or not targets.isdisjoint(reached):
                raise NotCarriedError("action parallel: more than commands to different devices")
            reached += targets
        return [*chain.from_iterable(branches)]

    def _repeated(self, fields: UnreadFields) -> list[Step]:
        """Read repeated actions, which are written so often."""
        count, steps = fields.text("count", "0"), self._branch(fields.items("sequence"))
        fields.end()
        is_plain = all(isinstance(step, str) and not step.startswith("wait until") for step in steps)
        times = int(count) if count.isdecimal() and len(count) <= _MAX_DIGITS else 0
        if not is_plain or not 0 < times * max(len(steps), 1) <= MAX_LINES:  # before they are written
            raise NotCarriedError(
                f"action repeat: carried over are commands and delays with a `count`, at most {MAX_LINES} together"
            )
        return steps * times

    def _pause(self) -> None:
        self._has_waited = True
        if self._is_split:
            raise NotCarriedError("a wait in an automation with `condition: trigger`: its parts become routines")

    def _awaited(self, fields: UnreadFields) -> str:
        """Return the state that is awaited. Home Assistant waits for its beginning, and a routine for the state.

        They differ if it holds already, which the trigger of the automation excludes until the first wait.
        """
        started_by = self._automation.starts
        waited = Automation(self._automation.entities, self._automation.problems)
        texts = waited.each(fields.items("wait_for_trigger"), "trigger", lambda node: read_triggers(waited, node))
        triggers = [text for some in texts for text in some]
        if len(triggers) != 1 or len(waited.starts) != 1:
            raise NotCarriedError("action wait_for_trigger: routines wait for one state")
        ((ids, states),) = waited.starts
        is_other = started_by and all(
            trigger_ids == ids and old and old.isdisjoint(states) for trigger_ids, old in started_by
        )
        if not is_other or self._has_waited or self._mode == "queued":
            raise NotCarriedError(
                "action wait_for_trigger: a routine would go on at once if it is so already; use wait_template"
            )
        return triggers[0]


def _choice(conditions: Sequence[Condition], steps: Sequence[Step], otherwise: Sequence[Step]) -> list[Step]:
    """Return the choice between *steps*, which are no choices, and *otherwise*."""
    if NEVER in conditions:
        return [*otherwise]
    if not conditions or not (steps or otherwise):
        return [*steps]
    if not steps:
        raise NotCarriedError("a choice that does something only if its conditions do not hold")
    texts, inner = texts_of(conditions), steps[0]
    if isinstance(inner, dict) and len(steps) == 1 and ("else" in inner or not otherwise):
        further = cast("list[str]", inner["if"])
        rest = [_choice_step(texts, cast("list[Step]", inner["else"]), otherwise)] if "else" in inner else []
        return [_choice_step([*texts, *further], cast("list[Step]", inner["do"]), rest)]
    return [_choice_step(texts, steps, otherwise)]


def _choice_step(texts: list[str], steps: Sequence[Step], otherwise: Sequence[Step]) -> dict[str, object]:
    if any(not isinstance(step, str) for step in steps):
        raise NotCarriedError("a choice in a choice; routines have one level")
    choice: dict[str, object] = {"if": texts, "do": [*steps]}
    return {**choice, "else": [*otherwise]} if otherwise else choice


_MODES: Final = frozenset({"single", "restart", "queued", "parallel"})
_USUAL: Final[Mapping[str, object]] = {"if": [], "mode": "single", "enabled": True}
_MAX_RUNS: Final = 10.0
"""The default of ``max``, and the limit of routines."""


class HomeAssistantAutomations:
    """Reader of ``automations.yaml``, and of packages and configurations with a key ``automation``."""

    def read(self, document: Located, source: str, devices: Sequence[Device], check: RoutineCheck) -> ImportedRoutines:
        """Return the routines of *document*; see :class:`homebot.words.automations.AutomationReader`."""
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
                written = (
                    [] if whole.problems else _written(tables, names, f"{source}, line {node.line}", entities, check)
                )
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


def _written(
    tables: Sequence[Mapping[str, object]], names: set[str], origin: str, entities: Entities, check: RoutineCheck
) -> list[str]:
    """Return the texts of *tables*, which homebot accepts, with their origin and the meaning of their entities."""
    known = "".join(
        f"# {entity.id}: {' '.join(entity.device.name.split())}{_in_unit(entity)}\n"
        for entity in entities.used.values()
    )
    texts = [routine_text(table) for table in tables]
    try:
        routines = [check(text, origin) for text in texts]
    except ConfigError as exc:
        raise NotCarriedError(f"{exc.key.rpartition('.')[2]}: {exc.reason}") from exc
    if not routines:
        raise NotCarriedError("it would do nothing")
    for routine in routines:
        if routine.app in names:
            raise NotCarriedError(f"another automation is called {routine.name!r}")
        names.add(routine.app)
    return [f"# {' '.join(origin.split())}\n{known}{text}" for text in texts]
