"""Actions of automations as steps of routines. Pure.

Source: Home Assistant core 2026.11, ``helpers/script.py``, and the services of its domains.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Final

from homebot.integrations.homeassistant.automations.conditions import NEVER, Condition, Conditions
from homebot.integrations.homeassistant.automations.entities import Entities
from homebot.integrations.homeassistant.automations.fields import (
    NotCarriedError,
    check_keys,
    duration_of,
    fields_of,
    flag_of,
    is_enabled,
    items_of,
    shown,
)
from homebot.integrations.homeassistant.automations.services import steps_of_service
from homebot.integrations.homeassistant.automations.states import state_text
from homebot.integrations.homeassistant.automations.triggers import StateTrigger, Triggers
from homebot.support.located import Located

__all__ = ["Actions", "Step"]

Step = str | dict[str, list[str]]
"""A step of a routine, or a choice between some."""

_GENERAL: Final = ("alias", "enabled", "continue_on_error", "metadata")
_IS_STATE: Final = re.compile(
    r"\{\{\s*(?:is_state\(\s*(?P<quote>['\"])(?P<entity>[\w.]+)(?P=quote)\s*,\s*(?P<quoted>['\"])(?P<state>[^'\"]+)(?P=quoted)\s*\)"
    r"|states\(\s*(?P<quote2>['\"])(?P<entity2>[\w.]+)(?P=quote2)\s*\)\s*==\s*(?P<quoted2>['\"])(?P<state2>[^'\"]+)(?P=quoted2))\s*\}\}"
)
_KINDS: Final = (
    "service", "action", "delay", "wait_template", "wait_for_trigger", "choose", "if", "sequence", "scene", "condition",
    "and", "or", "not", "repeat", "parallel", "variables", "stop", "event", "device_id", "set_conversation_response",
)  # fmt: skip


class Actions:
    """Reader of the actions of one automation.

    Args:
        started_by: The triggers of states of the automation.
        is_split: Whether there are several routines of it, which must not wait.
    """

    def __init__(
        self, entities: Entities, conditions: Conditions, started_by: Sequence[StateTrigger], *, is_split: bool
    ) -> None:
        self._entities = entities
        self._conditions = conditions
        self._started_by = started_by
        self._is_split = is_split
        self._has_waited = False

    def all_of(
        self, nodes: Sequence[Located], mode: str, problems: list[NotCarriedError]
    ) -> tuple[list[Condition], list[Step]]:
        """Return the conditions of the automation that its actions begin with, and its steps.

        A new run ends the one before it, or waits for it, before its actions ask for anything.
        """
        first, steps = self.read(nodes, problems)
        if not first or not self._has_waited or mode not in {"restart", "queued"}:
            return first, steps
        try:
            return [], _choice(first, steps, [], nodes[0].line)
        except NotCarriedError as exc:
            problems.append(exc)
            return [], []

    def read(self, nodes: Sequence[Located], problems: list[NotCarriedError]) -> tuple[list[Condition], list[Step]]:
        """Return the conditions at the beginning, and the steps; each problem is added to *problems*."""
        first: list[Condition] = []
        steps: list[Step] = []
        for number, node in enumerate(nodes):
            try:
                kind = _kind_of(node)
                if kind in {"condition", "and", "or", "not"} and not steps:
                    first += self._conditions.all_of([node])
                elif kind in {"condition", "and", "or", "not"}:
                    return first, [*steps, *self._rest(node, nodes[number + 1 :], problems)]
                else:
                    steps += self._steps(kind, node)
            except NotCarriedError as exc:
                problems.append(exc)
        return first, steps

    def _rest(self, node: Located, nodes: Sequence[Located], problems: list[NotCarriedError]) -> list[Step]:
        """Return the steps after a condition in the middle."""
        conditions = self._conditions.all_of([node])
        further, steps = self.read(nodes, problems)
        return _choice([*conditions, *further], steps, [], node.line)

    def _inner(self, nodes: Sequence[Located]) -> tuple[list[Condition], list[Step]]:
        problems: list[NotCarriedError] = []
        found = self.read(nodes, problems)
        if problems:
            raise problems[0]
        return found

    def _steps(self, kind: str, node: Located) -> list[Step]:
        fields = fields_of(node, "action")
        if not is_enabled(fields):
            return []
        match kind:
            case "service" | "action":
                return [*steps_of_service(self._entities, node, fields, kind)]
            case "scene":
                check_keys(node, "action scene", *_GENERAL, "scene")
                called = {"action": Located("scene.turn_on", node.line), "entity_id": fields["scene"]}
                return [*steps_of_service(self._entities, Located(called, node.line), called, "action")]
            case "delay":
                return self._delay(node, fields)
            case "wait_template" | "wait_for_trigger":
                return self._wait(kind, node, fields)
            case "if":
                return self._if(node, fields)
            case "choose":
                return self._choose(node, fields)
            case "sequence":
                check_keys(node, "action sequence", *_GENERAL, "sequence")
                conditions, steps = self._inner(items_of(fields["sequence"]))
                return _choice(conditions, steps, [], node.line)
        raise NotCarriedError(node.line, f"action: `{kind or shown(node)}` has no counterpart in routines")

    def _pause(self, line: int) -> None:
        self._has_waited = True
        if self._is_split:
            raise NotCarriedError(line, "a wait in an automation with `condition: trigger`: its parts become routines")

    def _delay(self, node: Located, fields: Mapping[str, Located]) -> list[Step]:
        check_keys(node, "action delay", *_GENERAL, "delay")
        self._pause(node.line)
        length = duration_of(fields["delay"], "delay")
        return [f"wait {length}"] if length else []

    def _wait(self, kind: str, node: Located, fields: Mapping[str, Located]) -> list[Step]:
        check_keys(node, f"action {kind}", *_GENERAL, kind, "timeout", "continue_on_timeout")
        if "timeout" not in fields or not duration_of(fields["timeout"], "timeout"):
            raise NotCarriedError(node.line, f"action {kind}: it may last forever; give it a `timeout`")
        if "continue_on_timeout" in fields and not flag_of(fields["continue_on_timeout"], "continue_on_timeout"):
            raise NotCarriedError(node.line, f"action {kind}: a routine goes on after the timeout")
        text = self._awaited(node, fields) if kind == "wait_for_trigger" else self._template(fields[kind])
        self._pause(node.line)
        return [f"wait until {text}, at most {duration_of(fields['timeout'], 'timeout')}"]

    def _awaited(self, node: Located, fields: Mapping[str, Located]) -> str:
        """Return the state that is awaited. Home Assistant waits for its beginning, and a routine for the state.

        They differ if it holds already, which the trigger of the automation excludes until the first wait.
        """
        waited = items_of(fields["wait_for_trigger"])
        reader = Triggers(self._entities)
        texts = [text for one in waited for text in reader.read(one)]
        if len(texts) != 1 or len(reader.states) != 1:
            raise NotCarriedError(node.line, "action wait_for_trigger: routines wait for one state")
        (awaited,) = reader.states
        is_other = self._started_by and all(
            one.entities == awaited.entities and one.states and one.states.isdisjoint(awaited.states)
            for one in self._started_by
        )
        if not is_other or self._has_waited:
            raise NotCarriedError(
                node.line,
                "action wait_for_trigger: a routine would go on at once if it is so already; use wait_template",
            )
        return texts[0]

    def _template(self, node: Located) -> str:
        found = _IS_STATE.fullmatch(str(node.value).strip())
        if found is None:
            raise NotCarriedError(node.line, f"wait_template: {shown(node)}; only is_state(...) is carried over")
        entity, state = (found[one] or found[f"{one}2"] for one in ("entity", "state"))
        return state_text(self._entities.find(entity, node.line), state, node.line)

    def _if(self, node: Located, fields: Mapping[str, Located]) -> list[Step]:
        check_keys(node, "action if", *_GENERAL, "if", "then", "else")
        conditions = self._conditions.all_of(items_of(fields["if"]))
        then, otherwise = (self._plain(fields.get(one), node.line) for one in ("then", "else"))
        return _choice(conditions, then, otherwise, node.line)

    def _choose(self, node: Located, fields: Mapping[str, Located]) -> list[Step]:
        """Read a choice; of several options all but one must be decided by the trigger."""
        check_keys(node, "action choose", *_GENERAL, "choose", "default")
        default = self._plain(fields.get("default"), node.line)
        options = []
        for one in items_of(fields["choose"]):
            check_keys(one, "choose", "conditions", "sequence", "alias", "enabled")
            inner = fields_of(one, "choose")
            conditions = self._conditions.all_of(items_of(inner.get("conditions"))) if is_enabled(inner) else [NEVER]
            if NEVER not in conditions:
                options.append((conditions, self._plain(inner.get("sequence"), one.line)))
        options = options[: next((place + 1 for place, one in enumerate(options) if not one[0]), len(options))]
        if len(options) > 1:
            raise NotCarriedError(node.line, "action choose: a routine chooses between two; make it two automations")
        return _choice(*options[0], default, node.line) if options else [*default]

    def _plain(self, node: Located | None, line: int) -> list[str]:
        """Return steps that are no choices."""
        conditions, steps = self._inner(items_of(node))
        plain = [one for one in steps if isinstance(one, str)]
        if len(plain) != len(steps) or conditions:
            raise NotCarriedError(line, "a choice in a choice; routines have one level")
        return plain


def _kind_of(node: Located) -> str:
    fields = fields_of(node, "action")
    return next((one for one in _KINDS if one in fields), "")


def _choice(conditions: Sequence[Condition], steps: Sequence[Step], otherwise: Sequence[str], line: int) -> list[Step]:
    if NEVER in conditions:
        return [*otherwise]
    if not conditions:
        return [*steps]
    if any(not isinstance(one, str) for one in steps):
        raise NotCarriedError(line, "a choice in a choice; routines have one level")
    plain = [one for one in steps if isinstance(one, str)]
    if not plain and not otherwise:
        return []
    if not plain:
        raise NotCarriedError(line, "a choice that does something only if its conditions do not hold")
    choice = {"if": [one.text for one in conditions], "do": plain}
    return [{**choice, "else": [*otherwise]} if otherwise else choice]
