"""Reader of files of automations: each becomes one routine, or is refused. Pure.

Source: Home Assistant core 2026.11, ``components/automation/config.py``, ``helpers/script.py`` and the services of its
domains; the keys of before 2024.10 count as well.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import chain
from typing import Final, cast

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device import Device
from homebot.errors import ConfigError, UsageError
from homebot.integrations.homeassistant.automations.conditions import (
    JOINTS,
    any_of,
    conditions_of,
    denied,
    template_text,
    templates_of,
    texts_of,
)
from homebot.integrations.homeassistant.automations.entities import (
    NEVER,
    Automation,
    Condition,
    Entities,
    KnownEntity,
    NamesOfIds,
    StartTrigger,
    is_of_device,
    slug_of,
)
from homebot.integrations.homeassistant.automations.event_triggers import own_event
from homebot.integrations.homeassistant.automations.expressions import round_limit
from homebot.integrations.homeassistant.automations.fields import (
    NotCarriedError,
    UnreadFields,
    called_service,
    items_of,
    service_name,
)
from homebot.integrations.homeassistant.automations.files import from_blueprint, groups_of, part_of, with_files
from homebot.integrations.homeassistant.automations.kept_values import with_snapshot
from homebot.integrations.homeassistant.automations.run_marks import marked_by, run_marks
from homebot.integrations.homeassistant.automations.services import Step, steps_of_service
from homebot.integrations.homeassistant.automations.template_calculations import step_length
from homebot.integrations.homeassistant.automations.template_times import random_ends
from homebot.integrations.homeassistant.automations.templates import keeps_state
from homebot.integrations.homeassistant.automations.triggers import read_triggers
from homebot.integrations.homeassistant.automations.variables import plain, resolved, without_run_id
from homebot.integrations.homeassistant.formats.jinja.values import UNDEFINED
from homebot.support.located import Located
from homebot.words.automations import ImportedRoutines, Load, Refusal, RoutineCheck
from homebot.words.routine_text import routine_text
from homebot.words.steps import MAX_ROUNDS, MAX_RUNS, Do, Stop, Undo, Wait, WaitFor, WaitUntil, read_step
from homebot.words.triggers import read_state, read_trigger

_CONDITIONS: Final = frozenset({"condition", *JOINTS})
_KINDS: Final = (
    *("service", "action", "scene", "delay", "wait_template", "wait_for_trigger", "choose", "if", "sequence"),
    *("repeat", "parallel", "variables", "stop", "event", "device_id", "set_conversation_response"),
)

_MAX_DIGITS: Final = 4
_FOREVER: Final = "365d"
_ENDING: Final = {"siren.turn_on": "siren.turn_off"}
"""Services with a length, after which the other one follows by itself."""

_MAX_WRITTEN: Final = 50
"""Steps that repeated actions become if each round is written."""


class Actions:
    """Reader of the actions of one automation.

    Args:
        mode: The mode of the automation.
        scripts: The scripts that its actions may call, by name.
    """

    def __init__(self, automation: Automation, mode: str, scripts: Mapping[str, Located]) -> None:
        self._automation = automation
        self._mode = mode
        self._scripts = scripts
        self._in_scripts: list[str] = []
        self._snapshots: dict[str, set[str]] = {}
        self._commanded: set[str] = set()
        self._forgotten: set[str] = set()
        self._is_sure = True
        self._ends: list[str] = []

    @property
    def mode(self) -> str:
        """The mode of the routine: one that only waits for the end of its siren begins anew."""
        return "restart" if self._ends else self._mode

    def all_of(self, nodes: Sequence[Located]) -> tuple[list[Condition], list[Step]]:
        """Return the conditions of the automation that its actions begin with, and its steps.

        A new run ends the one before it, or waits for it, before its actions ask for anything.
        """
        first, steps = self._read_kept(nodes)
        if self._ends:
            if _waits(_single(steps)):
                raise NotCarriedError("data: `duration` beside a wait; write the steps `wait 2m` and `off` after it")
            steps += self._ends
        if first and self._automation.has_waited and self._mode in {"restart", "queued"}:
            with self._automation.in_line(nodes[0].line):
                first, steps = [], _choice(first, steps, [])
        return first, steps

    def _read(self, nodes: Sequence[Located]) -> tuple[list[Condition], list[Step]]:
        """Return the conditions at the beginning, and the steps; conditions in the middle decide over the rest."""
        first: list[Condition] = []
        steps: list[Step] = []
        for number, node in enumerate(nodes):
            fields = _fields_of(node)
            if "variables" in fields and not service_name(fields):
                with self._automation.in_line(node.line):
                    constants = self._automation.define(fields["variables"])
                    further, rest = self._read_with(constants, fields["variables"], nodes[number + 1 :])
                    first += further if not steps else []
                    steps += _choice(further, rest, []) if steps else rest
                break
            if isinstance(node.value, dict) and _CONDITIONS.isdisjoint(node.value):
                for step in chain(*self._automation.each([node], "action", self._steps)):
                    if steps and step == steps[-1] and isinstance(step, str) and step.startswith("notify "):
                        self._automation.notes.append("a message to several is one to all of [notify]")
                    else:
                        steps.append(step)
                continue
            first_here = conditions_of(self._automation, [node])
            if not steps:
                first += first_here
                continue
            was_sure, self._is_sure = self._is_sure, False
            further, rest = self._read(nodes[number + 1 :])
            self._is_sure = was_sure
            with self._automation.in_line(node.line):
                steps += _choice([*first_here, *further], rest, [])
            break
        return first, steps

    def _read_with(
        self, constants: Mapping[str, object], variables: Located, nodes: Sequence[Located]
    ) -> tuple[list[Condition], list[Step]]:
        """Read *nodes* with variables; one that keeps whether a state was so is a choice between two ways."""
        nodes = self._with_snapshot(nodes)
        names = [name for name in cast("dict[str, Located]", variables.value) if name in self._automation.expressions]
        for name in names:
            text = self._automation.expressions[name]
            uses = [number for number, node in enumerate(nodes) if name in str(node)]
            is_kept = bool(uses) and keeps_state(text)
            if len(uses) > 1 and not is_kept and (chosen := templates_of(self._automation).ways(Located(text, 0))):
                return [], self._by_value(name, chosen, constants, nodes)
            if is_kept and 0 not in uses:
                return [], self._by_truth(name, constants, nodes)
        return self._read([resolved(other, constants) for other in nodes])

    def _read_kept(self, nodes: Sequence[Located]) -> tuple[list[Condition], list[Step]]:
        """Read *nodes* with the variables of the automation; one that is asked after a command has its first value."""
        for name, text in self._automation.expressions.items():
            uses = [number for number, node in enumerate(nodes) if name in str(node)]
            called = [
                service_name(node.value) for node in nodes[: max(uses, default=0)] if isinstance(node.value, dict)
            ]
            if any(called) and keeps_state(text):
                return [], self._by_truth(name, {}, nodes)
        return self._read(self._with_snapshot(nodes))

    def _by_truth(self, name: str, constants: Mapping[str, object], nodes: Sequence[Located]) -> list[Step]:
        """Read *nodes* with a variable that is true, and with it as false."""
        held = templates_of(self._automation).conditions(self._automation.expressions[name])
        rest = {key: value for key, value in self._automation.expressions.items() if key != name}
        ways = []
        for value in (True, False):
            self._automation.expressions = dict(rest)
            ways.append(self._branch([resolved(node, {**constants, name: value}) for node in nodes]))
        return _choice(held, *ways)

    def _with_snapshot(self, nodes: Sequence[Located]) -> Sequence[Located]:
        """Return *nodes* with a snapshot of the entity whose values variables keep to bring them back; else as is."""
        if (kept := with_snapshot(self._automation.expressions, nodes)) is None:
            return nodes
        entity_id, actions = kept
        if (entity := self._automation.entities.find(entity_id)).name in self._commanded:
            return nodes
        self._snapshots[f"scene.kept {entity_id}"] = {entity.name}
        return actions

    def _by_value(
        self,
        name: str,
        ways: Sequence[tuple[list[Condition], Located]],
        constants: Mapping[str, object],
        nodes: Sequence[Located],
    ) -> list[Step]:
        """Read *nodes* for each value between which the template of a variable chooses, which it keeps."""
        rest = {key: value for key, value in self._automation.expressions.items() if key != name}
        choice: list[Step] = []
        for held, value in reversed(ways):
            self._automation.expressions, known = dict(rest), dict(constants)
            if isinstance(value.value, str) and "{" in value.value:
                self._automation.expressions[name] = value.value
            else:
                known[name] = value
            if NEVER not in held:
                choice = _choice(held, self._branch([resolved(node, known) for node in nodes]), choice)
        return choice

    def _steps(self, fields: UnreadFields) -> Sequence[Step]:
        """Return the steps of an action; variables that a branch may have changed are forgotten behind all of them."""
        before, self._forgotten = self._forgotten, set()
        steps = self._steps_of_kind(fields)
        expressions = self._automation.expressions
        self._automation.expressions = {name: text for name, text in expressions.items() if name not in self._forgotten}
        self._forgotten = before
        return steps

    def _steps_of_kind(self, fields: UnreadFields) -> Sequence[Step]:
        if (older := fields.take("service_template")) is not None:
            fields.left["service"] = older
        kind = fields.first_of(_KINDS)
        match kind:
            case "service" | "action" | "scene" | "device_id":
                return self._service(fields, kind)
            case "delay":
                return self._delay(fields)
            case "wait_template" | "wait_for_trigger":
                return self._wait(fields, kind)
            case "stop":
                fields.text("stop", "")
                fields.flag("error", default=False)
                if self._in_scripts:
                    raise NotCarriedError("action stop: it ends a script alone, and `stop` a whole run")
                return ["stop"]
            case "if":
                conditions = conditions_of(self._automation, fields.items("if"))
                steps = self._branch(fields.items("then"), conditions)
                return _choice(conditions, steps, self._branch(fields.items("else")))
            case "choose":
                default = self._branch(fields.items("default"))
                options = self._automation.each(fields.items("choose"), "choose", self._option)
                for conditions, steps in reversed(options):  # each is tried if those before it do not hold
                    default = _choice(conditions, steps, default)
                return default
            case "sequence":
                return self._branch(fields.items("sequence"), is_sure=True)
            case "parallel":
                return self._parallel(fields)
            case "event":
                return self._event(fields)
            case "repeat":
                return self._repeated(fields.inner("repeat"))
            case "":
                fields.end()
        raise NotCarriedError(f"action: `{kind}` has no counterpart in routines")

    def _service(self, fields: UnreadFields, kind: str) -> Sequence[Step]:
        """Read the call of a service; for each value that a template chooses it is one branch of a choice."""
        if (mark := marked_by(fields.left)) in self._automation.entities.marks:
            fields.left.clear()
            self._automation.notes.append(f"{mark} is the time of the last run, which homebot knows itself")
            return []
        self._take_length(fields)
        call = Located(dict(fields.left), 0)
        ways = templates_of(self._automation).ways(call)
        if not ways:
            if (steps := self._kept_scene(fields, kind)) is None:
                steps = self._script(fields, kind) or steps_of_service(self._automation, fields, kind)
            commands = {step.target for step in _single(steps) if isinstance(step, Do)}
            self._commanded |= commands
            if commands:
                self._automation.forget_values(by_command=True)
            return steps
        fields.left.clear()
        choice: Sequence[Step] = []
        for conditions, node in reversed(ways):
            if NEVER in conditions:
                continue
            way, triggers = UnreadFields(node, "action"), self._automation.triggers
            self._automation.triggers = self._started(conditions)
            with self._beside_others():
                steps = self._service(way, kind)
            self._automation.triggers = triggers
            way.end()
            choice = _choice(conditions, steps, choice)
        return choice

    def _take_length(self, fields: UnreadFields) -> None:
        """Take the length from the call of a service that ends by itself: its end follows all other steps.

        Raises:
            NotCarriedError: Not each run comes to it, or there are several.
        """
        data, name = fields.left.get("data"), service_name(fields.left)
        if name not in _ENDING or data is None or not isinstance(data.value, dict) or "duration" not in data.value:
            return
        if not self._is_sure or self._ends:
            raise NotCarriedError(
                "data: `duration` of a step that not each run takes; write the steps `wait 2m` and `off`"
            )
        length = UnreadFields(data, "data").duration("duration")
        fields.left["data"] = data._replace(value={key: one for key, one in data.value.items() if key != "duration"})
        kept = {key: one for key, one in fields.left.items() if key in {"target", "entity_id"}}
        call = UnreadFields(Located({**kept, "action": Located(_ENDING[name], 0)}, 0), "action")
        self._ends = [f"wait {length}", *cast("list[str]", steps_of_service(self._automation, call, "action"))]

    def _started(self, conditions: Sequence[Condition]) -> list[StartTrigger]:
        """Return the triggers that may have started a branch with *conditions*."""
        triggers = self._automation.triggers
        for condition in conditions:
            if all(text.startswith("started by ") for text in condition):
                triggers = [trigger for trigger in triggers if f"started by {trigger.text}" in condition]
        return triggers

    def _kept_scene(self, fields: UnreadFields, key: str) -> Sequence[Step] | None:
        """Return the steps of a scene that keeps the values of entities, or brings them back; None for another call."""
        node = fields.left.get(key)
        match str(node.value if node else ""):
            case "scene.create":
                fields.take(key)
                data = fields.inner("data", "data_template")
                scene, entities = data.text("scene_id"), data.texts("snapshot_entities")
                data.end()
                known = [*map(self._automation.entities.find, entities)]
                if before := self._commanded & {entity.name for entity in known}:
                    raise NotCarriedError(
                        f"scene.create after a command to {min(before)}: `undo` would bring back the values before that"
                    )
                if not known:
                    raise NotCarriedError("scene.create: `snapshot_entities` is missing; write the scene in homebot")
                self._snapshots[f"scene.{scene}"] = {entity.name for entity in known}
                return []
            case "scene.turn_on" | "scene.apply":
                ids = called_service(fields.left).entities
                if len(ids) != 1 or ids[0] not in self._snapshots:
                    if kept := next(filter(self._automation.keeps_scene, ids), ""):
                        raise NotCarriedError(f"{kept} may be of another run, and `undo` is of this one")
                    return None
                if others := self._commanded - self._snapshots[ids[0]]:
                    raise NotCarriedError(
                        f"{ids[0]}: `undo` would bring back {min(others)} too; set the values by steps"
                    )
                fields.left.clear()
                self._automation.notes.append("`undo` brings back what nothing else has changed since")
                return ["undo"]
        return None

    def _branch(self, nodes: Sequence[Located], held: Sequence[Condition] = (), *, is_sure: bool = False) -> list[Step]:
        """Return the steps of a branch, in which the conditions *held* hold: only some triggers can have started it."""
        triggers, self._automation.triggers = self._automation.triggers, self._started(held)
        known, snapshots = dict(self._automation.constants), dict(self._snapshots)
        waited = self._automation.waited
        was_sure, self._is_sure = self._is_sure, self._is_sure and is_sure
        with self._beside_others():
            conditions, steps = self._read(nodes)
        self._is_sure = was_sure
        if self._automation.waited is not waited:  # it may have waited for something else
            self._automation.waited = []
        self._automation.constants, self._snapshots = known, snapshots  # those of a branch are its own
        self._automation.triggers = triggers
        return _choice(conditions, steps, [])

    @contextmanager
    def _beside_others(self) -> Iterator[None]:
        """Read a branch; its commands have changed no variable in those beside it."""
        expressions = self._automation.expressions
        yield
        self._forgotten |= expressions.keys() - self._automation.expressions.keys()
        self._automation.expressions = expressions

    def _option(self, fields: UnreadFields) -> tuple[list[Condition], list[Step]]:
        conditions = conditions_of(self._automation, fields.items("conditions"))
        nodes = fields.items("sequence")
        return conditions, [] if NEVER in conditions else self._branch(nodes, conditions)

    def _called_script(self, fields: UnreadFields, key: str) -> tuple[str, UnreadFields]:
        """Return the script that is called, and its values; an empty name if another service is called."""
        called = fields.left.get(key)
        domain, _, name = str(called.value if called else "").partition(".")
        given, is_turned_on = UnreadFields(Located({}, 0), "data"), (domain, name) == ("script", "turn_on")
        if is_turned_on:
            _, ids, data = called_service(fields.left)
            name = ids[0].removeprefix("script.") if len(ids) == 1 else ""
            given = data.inner("variables")
            data.end()
        if key not in {"service", "action"} or domain != "script" or name not in self._scripts:
            return "", given
        if name in self._in_scripts:
            raise NotCarriedError(f"script.{name} calls itself")
        if is_turned_on:
            fields.left.clear()
            self._automation.notes.append(f"script.{name} is awaited, where Home Assistant goes on at once")
            return name, given
        fields.take(key)
        return name, fields.inner("data", "service_data")

    def _script(self, fields: UnreadFields, key: str) -> Sequence[Step]:
        """Return the steps of the script that is called; none if another service is."""
        name, given = self._called_script(fields, key)
        if not name:
            return []
        script = UnreadFields(self._scripts[name], "script")
        inputs = script.take("fields")
        for field in ("description", "icon", "max"):
            script.take(field)
        mode = script.text("mode", "single")
        known, expressions = dict(self._automation.constants), dict(self._automation.expressions)
        missing = {field: Located(UNDEFINED, 0) for field in _fields_of(inputs) if field not in given}
        constants = self._automation.define(Located({**missing, **given.left}, 0))
        if (own := script.take("variables")) is not None:
            constants = self._automation.define(own)
        self._in_scripts.append(name)
        steps = self._branch([resolved(node, constants) for node in script.items("sequence")])
        self._in_scripts.pop()
        script.end()
        if _waits(_single(steps)) and mode != "parallel" and self._automation.calls_of(name) > 1:
            raise NotCarriedError(
                f"script.{name}: it waits, and several automations call it in turn; call it by one, or write its steps "
                "without a wait"
            )
        self._automation.constants, self._automation.expressions = known, expressions
        self._automation.forget_values()
        return steps

    def _event(self, fields: UnreadFields) -> list[Step]:
        """Return the press of the helper that stands for an event, without its data."""
        kind = fields.text("event")
        fields.take("event_data")  # a trigger that asks for it is refused
        asked = re.compile(rf"'event_type': \[?{re.escape(repr(kind))}")
        if not any(map(asked.search, {*self._automation.calling, *self._automation.others})):
            self._automation.notes.append(f"the event {kind} is left out: no automation of this file waits for it")
            return []
        return [f"{own_event(self._automation, kind).name} press"]

    def _delay(self, fields: UnreadFields) -> list[Step]:
        node = fields.left.get("delay")
        self._automation.has_waited = True
        if node is not None and (ends := random_ends(node)):
            least, most = (UnreadFields(Located({"delay": end}, node.line), "delay").duration("delay") for end in ends)
            fields.take("delay")
            return [f"wait {least or '0s'} to {most}"]
        if node is not None and (ways := templates_of(self._automation).ways(node)):
            fields.take("delay")
            choice: list[Step] = []
            for held, value in reversed(ways):
                choice = _choice(held, self._delay(UnreadFields(Located({"delay": value}, 0), "delay")), choice)
            return choice
        if node is not None and (length := step_length(self._automation, node)):
            fields.take("delay")
            return [f"wait {length}"]
        length = fields.duration("delay")
        return [f"wait {length}"] if length else []

    def _wait(self, fields: UnreadFields, kind: str) -> list[Step]:
        most = fields.duration("timeout")
        if not most:
            self._automation.notes.append("its wait has no end in Home Assistant, and ends here after a year")
        stops = not most or not fields.flag("continue_on_timeout", default=True)
        fields.take("continue_on_timeout")
        end = f", at most {most or _FOREVER}{', then stop' if stops else ''}"
        if stops and self._in_scripts:
            raise NotCarriedError(f"action {kind}: in a script its end would end the whole run")
        if kind == "wait_for_trigger":
            waited = Automation(self._automation.entities, self._automation.names, self._automation.problems)
            for number, trigger in enumerate(fields.items(kind)):
                _add_triggers(waited, trigger, number)
            texts = [one.text for one in waited.triggers]
            if not texts and waited.problems:
                return []
            if any(one.needs for one in waited.triggers):
                raise NotCarriedError("action wait_for_trigger: a template of several states; use `wait_template`")
            text = _wait_for(texts, end, "wait_for_trigger: these triggers")
            self._automation.waited = waited.triggers
        else:
            self._automation.waited = []
            node = fields.take(kind)
            held = templates_of(self._automation).conditions(template_text(node))
            return self._waited(_awaited(held, end))
        return self._waited([text])

    def _waited(self, steps: list[Step]) -> list[Step]:
        self._automation.has_waited = True
        self._automation.forget_values()
        return steps

    def _parallel(self, fields: UnreadFields) -> list[Step]:
        """Read simultaneous actions, which may be given in a row for different devices: first the one that asks."""
        branches = [self._branch([node], is_sure=True) for node in fields.items("parallel")]
        reached, asking, waiting = list[str](), list[list[Step]](), list[list[Step]]()
        is_changed = False
        for branch in branches:
            steps = [*_single(branch)]
            targets = {step.target for step in steps if isinstance(step, Do)}
            if asked := _asked_in(steps):
                is_changed |= any(changed in asked for changed in ("light ", *reached) if asking)
                asking.append(branch)
            if _waits(steps):
                waiting.append(branch)
            if not targets.isdisjoint(reached) or Stop() in steps:
                raise NotCarriedError("action parallel: a stop, or commands to one device")
            reached += targets
        if is_changed or any(branch in waiting for branch in asking):
            raise NotCarriedError("action parallel: a condition about what another one commands, or beside a wait")
        plain_branches = [branch for branch in branches if branch not in asking and branch not in waiting]
        return [*chain(*asking, *plain_branches), *(_at_once(waiting) if len(waiting) > 1 else chain(*waiting))]

    def _repeated(self, fields: UnreadFields) -> list[Step]:
        """Read repeated actions: a loop, or each round as it is written if that differs by its number or value."""
        is_at_once = re.search("delay|wait_|script", str(fields.left)) is None
        self._automation.forget_values(by_command=is_at_once)  # a variable has its value from before the first round
        nodes, kind = fields.items("sequence"), fields.first_of(("count", "while", "until", "for_each"))
        if kind in {"while", "until"}:
            limit = round_limit(fields.left[kind], is_until=kind == "until")
            held = conditions_of(self._automation, [limit[1]] if limit else fields.items(kind))
            fields.take(kind)
            fields.end()
            if limit is None:
                return [{kind: texts_of(held), "do": self._branch(nodes)}]
            return self._limited(nodes, held, limit[0], is_until=kind == "until")
        if kind == "for_each":
            values: list[object] = [node._replace(line=0) for node in fields.items("for_each")]
        else:
            count = fields.text("count", "0")
            times = int(count) if count.isdecimal() and len(count) <= _MAX_DIGITS else 0
            if not times:
                raise NotCarriedError(f"action repeat: `count` {count!r} is no number of rounds")
            if not _tells_round(nodes):
                fields.end()
                steps = self._branch(nodes)
                if times > MAX_ROUNDS:
                    raise NotCarriedError(f"action repeat: {times} rounds; {MAX_ROUNDS} is the limit")
                return [{"repeat": times, "do": steps}] if steps else []
            values = [None] * min(times, _MAX_WRITTEN + 1)
        fields.end()
        steps = []
        for number, value in enumerate(values, 1):
            place = {"index": number, "first": number == 1, "last": number == len(values), "item": value}
            steps += self._branch([resolved(node, {"repeat": place}) for node in nodes])
            if len(steps) > _MAX_WRITTEN:
                raise NotCarriedError(f"action repeat: more than {_MAX_WRITTEN} steps that differ by round")
        return steps

    def _limited(self, nodes: Sequence[Located], held: Sequence[Condition], most: int, *, is_until: bool) -> list[Step]:
        """Read a loop with *most* rounds, each written for itself if it tells its number."""
        if most > MAX_ROUNDS:
            raise NotCarriedError(f"action repeat: {most} rounds; {MAX_ROUNDS} is the limit")
        goes_on = denied(held) if is_until else [*held]
        if not _tells_round(nodes):
            steps, rounds = self._branch(nodes), most - is_until
            again: list[Step] = [{"repeat": rounds, "do": _choice(goes_on, steps, [])}] if rounds else []
            return [*(steps if is_until else []), *again]  # the rounds after its end take no time
        rounds_of_steps: Sequence[Step] = []
        for number in range(most, 0, -1):
            place = {"index": number, "first": number == 1, "last": number == most}
            body = [*self._branch([resolved(node, {"repeat": place}) for node in nodes]), *rounds_of_steps]
            is_asked = number > 1 or not is_until
            rounds_of_steps = _choice(goes_on, body, []) if is_asked else body
        if len([*_single(rounds_of_steps)]) > _MAX_WRITTEN:
            raise NotCarriedError(f"action repeat: more than {_MAX_WRITTEN} steps that differ by round")
        return [*rounds_of_steps]


def _fields_of(node: Located | None) -> Mapping[str, Located]:
    return node.value if node is not None and isinstance(node.value, dict) else {}


def _single(steps: Iterable[Step]) -> Iterator[object]:
    """Yield the steps in *steps* and in their choices, as they are read, and choices and loops as they are."""
    for step in steps:
        if isinstance(step, str):
            yield read_step(step)
            continue
        yield step
        yield from _single(
            cast("list[Step]", [*cast("list[Step]", step["do"]), *cast("list[Step]", step.get("else", []))])
        )


def _waits(steps: Iterable[object]) -> bool:
    return any(isinstance(step, Wait | WaitFor | WaitUntil) for step in steps)


def _asked_in(steps: Iterable[object]) -> str:
    """Return the conditions of the choices and loops in *steps*; empty without a choice."""
    asking = [step for step in steps if isinstance(step, dict)]
    is_choice = any("repeat" not in step for step in asking)
    return " ".join(text for step in asking for text in step.get("if", ["light "])) if is_choice else ""


def _tells_round(nodes: Iterable[Located]) -> bool:
    return any("repeat." in str(node) for node in nodes)


def _at_once(branches: Sequence[Sequence[Step]]) -> list[Step]:
    """Return the steps of *branches* that begin together and wait for fixed lengths, in the order of their times."""
    timed: list[tuple[float, Step]] = []
    for branch in branches:
        now = 0.0
        for text in branch:
            step = None if isinstance(text, dict) else read_step(text)
            is_fixed = not isinstance(step, Wait) or not (step.pieces or step.most)
            if step is None or isinstance(step, WaitFor | WaitUntil | Undo) or not is_fixed:
                raise NotCarriedError("action parallel: several that ask or wait for states; write them in a row")
            if isinstance(step, Wait):
                now += step.seconds
            else:
                timed.append((now, text))
    steps: list[Step] = []
    now = 0.0
    for at, text in sorted(timed, key=lambda row: row[0]):
        steps += [f"wait {at - now:.12g}s", text] if at > now else [text]
        now = at
    return steps


def _choice(conditions: Sequence[Condition], steps: Sequence[Step], otherwise: Sequence[Step]) -> list[Step]:
    """Return the choice between *steps* and *otherwise*."""
    if NEVER in conditions:
        return [*otherwise]
    if not conditions or not (steps or otherwise):
        return [*steps]
    if not steps:
        return _choice(denied(conditions), otherwise, [])
    texts, inner = texts_of(conditions), steps[0]
    if isinstance(inner, dict) and "if" in inner and len(steps) == 1 and "else" not in inner and not otherwise:
        return [{"if": [*texts, *cast("list[str]", inner["if"])], "do": inner["do"]}]
    choice: dict[str, object] = {"if": texts, "do": [*steps]}
    return [{**choice, "else": [*otherwise]} if otherwise else choice]


_IN_BRACKETS: Final = re.compile(r"^(not )?\(((?:name|id)=.*)\)$")


def _is_state(text: str) -> bool:
    is_calculated = text.startswith(("{", "not {"))
    return not is_calculated and (is_of_device(text) or text.endswith((" is home", " is away")))


def _awaited(held: Sequence[Condition], end: str) -> list[Step]:
    """Return the steps that wait until *held*: for states at one time, or for the next change to one of several."""
    texts = [text for condition in held for text in condition]
    states = [_IN_BRACKETS.sub(r"\1\2", text) for text in texts]
    if not texts or not all(map(_is_state, texts)):
        raise NotCarriedError("action wait_template: a routine waits for states; write a loop with `until`")
    if all(len(condition) == 1 for condition in held):
        positive = [state.replace("not ", "no ", 1) if state.startswith("not ") else state for state in states]
        text = f"wait until {' and until '.join(positive)}{end}"
        step = read_step(text)
        if not isinstance(step, WaitUntil) or step.states != tuple(map(read_state, positive)):
            raise NotCarriedError("action wait_template: these states cannot be written as one step")
        return [text]
    if len(held) > 1:
        raise NotCarriedError("action wait_template: `or` beside `and`; wait for one after the other")
    return _choice(denied(held), [_wait_for(states, end, "wait_template: these states")], [])


def _wait_for(triggers: Sequence[str], end: str, what: str) -> str:
    """Return the step that waits for one of *triggers*, which are *what* in a refusal."""
    text = f"wait for {' or '.join(triggers)}{end}"
    step = read_step(text) if triggers else None
    if not isinstance(step, WaitFor) or step.triggers != tuple(map(read_trigger, triggers)):
        raise NotCarriedError(f"action {what} cannot be written as one step")
    return text


_MODES: Final = frozenset({"single", "restart", "queued", "parallel"})
_USUAL: Final[Mapping[str, object]] = {"if": [], "mode": "single", "max": MAX_RUNS, "enabled": True}


class HomeAssistantAutomations:
    """Reader of ``automations.yaml``, and of packages and configurations with a key ``automation``."""

    def read(
        self,
        document: Located,
        source: str,
        devices: Sequence[Device],
        check: RoutineCheck,
        *,
        scenes: Sequence[str] = (),
        routines: Sequence[str] = (),
        load: Load | None = None,
        blueprint: Located | None = None,
    ) -> ImportedRoutines:
        """Return the routines of *document*; see :class:`homebot.words.automations.AutomationReader`."""
        document = with_files(document, load)
        nodes = [*_automations(document)]
        if not nodes:
            raise UsageError(f"{source} has no automations")
        scripts = part_of(document, "script", load)
        aliases = [_name(node) for node in nodes]
        own = {slug_of(name): name for name in aliases}
        names = NamesOfIds(
            {slug_of(name): name for name in scenes}, {slug_of(name): name for name in (*routines, *aliases)}
        )
        texts: dict[str, list[str]] = {}
        called: dict[str, tuple[int, set[str]]] = {}
        refused: list[Refusal] = []
        apps: set[str] = set()
        entities = Entities(devices, groups_of(document, load))
        written_nodes = [str(plain(node)) for node in nodes]
        written_scripts = [str(plain(script)) for script in scripts.values()]
        for place, (node, name) in enumerate(zip(nodes, aliases, strict=True)):
            entities.used.clear()
            entities.notes.clear()
            entities.marks = {}
            others = [*written_nodes[:place], *written_nodes[place + 1 :], *written_scripts]
            automation = Automation(entities, names, calling=written_nodes, others=others)
            written: list[str] = []
            with automation.in_line(node.line):
                plain_node = from_blueprint(node, blueprint, load) if "use_blueprint" in _fields_of(node) else node
                plain_node = without_run_id(plain_node)
                table = _table(automation, UnreadFields(plain_node, "automation"), name, scripts)
                if not automation.problems:
                    written = _written(table, apps, f"{source}, line {node.line}", automation, check)
            if written and not automation.problems:
                texts.setdefault(name, []).extend(written)
                called[name] = node.line, {*filter(partial(_is_named, written[0]), own.values())}
            refused += dict.fromkeys(Refusal(problem.line, name, str(problem)) for problem in automation.problems)
        for name, (line, switched) in called.items():
            if missing := switched - texts.keys() - {*routines}:
                del texts[name]
                refused.append(Refusal(line, name, f"it names {min(missing)!r}, which is not carried over"))
        return ImportedRoutines(tuple(chain(*texts.values())), tuple(refused), len(nodes))


def _is_named(text: str, routine: str) -> bool:
    """Return whether a step of the routine *text* switches, or runs, another *routine*."""
    return f'"routine {routine} o' in text or f'"run routine {routine}"' in text


def _name(node: Located) -> str:
    named = _fields_of(node)
    alias = next((str(named[key].value) for key in ("alias", "id") if key in named), "")
    return " ".join(alias.split())[:80] or f"automation in line {node.line}"


def _automations(document: Located) -> Iterator[Located]:
    if isinstance(document.value, dict) and not {"trigger", "triggers", "use_blueprint"} & document.value.keys():
        for key, value in document.value.items():
            if key.partition(" ")[0] == "automation":
                yield from [value] if value.tag else items_of(value, key)
        return
    yield from document.value if isinstance(document.value, list) else items_of(document, "automations")


def _table(
    automation: Automation, fields: UnreadFields, name: str, scripts: Mapping[str, Located]
) -> dict[str, object] | None:
    """Return the table of the routine of an automation; None for one that would never do anything."""
    ids = {slug_of(name), fields.text("id", "")}
    automation.own_ids = frozenset(ids - {""})
    for key in ("description", "trace", "max_exceeded"):
        fields.take(key)
    mode, most = fields.text("mode", "single"), fields.numbers("max")
    if mode not in _MODES:
        raise NotCarriedError(f"mode: {mode!r}")
    enabled = fields.flag("initial_state", default=True)
    automation.constants["this.entity_id"] = f"automation.{slug_of(name)}"
    constants: Mapping[str, object] = automation.constants
    for key in ("trigger_variables", "variables"):
        if (node := fields.take(key)) is not None:
            constants = automation.define(node)
    triggers, conditions, actions = (
        [resolved(node, constants) for node in fields.items(key, f"{key}s")]
        for key in ("trigger", "condition", "action")
    )
    with automation.in_line(0):
        fields.end()
    automation.entities.marks = run_marks(actions, automation.others)
    for number, node in enumerate(triggers):
        _add_triggers(automation, node, number)
    held = [*_needs(automation), *conditions_of(automation, conditions)]
    reader = Actions(automation, mode, scripts)
    first, steps = reader.all_of(actions)
    held += first
    when = [*dict.fromkeys(trigger.text for trigger in automation.triggers)]
    if NEVER in held or not steps or not when:
        return None
    table = {
        "name": name,
        "when": when,
        "if": texts_of(held),
        "do": steps,
        "mode": reader.mode,
        "max": int(most[0]) if most and mode in {"queued", "parallel"} else MAX_RUNS,
        "enabled": enabled,
    }
    return {key: value for key, value in table.items() if _USUAL.get(key) != value}


def _add_triggers(automation: Automation, node: Located, number: int) -> None:
    """Add the triggers of *node*, each with its id, else its number in the automation."""
    named = _fields_of(node)
    given = named.get("id")
    known = automation.each([node], "trigger", partial(read_triggers, automation))
    with automation.in_line(node.line):
        if given is not None and not isinstance(given.value, str | int):
            raise NotCarriedError(f"id: {plain(given)} is not a text")
    trigger_id = str(number if given is None else given.value)
    facts = [(_FACTS[key], str(value.value)) for key, value in named.items() if key in _FACTS]
    automation.triggers += [trigger._replace(id=trigger_id, data=(*trigger.data, *facts)) for trigger in chain(*known)]


_FACTS: Final = {"trigger": "platform", "platform": "platform", "event": "event"}
"""The fields of ``trigger.…`` by those of the trigger, for which they are known before it starts."""


def _needs(automation: Automation) -> Iterator[Condition]:
    """Yield the conditions of single triggers, from which the other ones are free."""
    for needs in dict.fromkeys(trigger.needs for trigger in automation.triggers if trigger.needs):
        others = [trigger for trigger in automation.triggers if trigger.needs != needs]
        started = templates_of(automation).started_by(others) if others else [NEVER]
        yield from any_of([[*needs], started])


def _in_unit(entity: KnownEntity) -> str:
    """Return the unit in which homebot has a sensor: the one in Home Assistant may differ, and is not always known."""
    unit = CAPABILITIES.get(entity.capability, OWN).unit
    return f", in {unit}" if unit else ""


def _written(
    table: Mapping[str, object] | None, apps: set[str], origin: str, automation: Automation, check: RoutineCheck
) -> list[str]:
    """Return the text of *table*, which homebot accepts, with its origin and the meaning of its entities."""
    if table is None:
        raise NotCarriedError("it would do nothing")
    known = "".join(
        f"# {entity.id}: {' '.join(entity.device.name.split())}{_in_unit(entity)}\n"
        for entity in automation.entities.used.values()
    )
    notes = dict.fromkeys((*automation.notes, *automation.entities.notes))
    known += "".join(f"# note: {' '.join(note.split())}\n" for note in notes)
    text = routine_text(table)
    try:
        routine = check(text, origin)
    except ConfigError as exc:
        raise NotCarriedError(f"{exc.key.rpartition('.')[2]}: {exc.reason}") from exc
    if routine.app in apps:
        raise NotCarriedError(f"another automation is called {routine.name!r}")
    apps.add(routine.app)
    return [f"# {' '.join(origin.split())}\n{known}{text}"]
