"""Checks of the routines of a house: names and values that it lacks, and routines that meet.

A device that is not there yet may still come, so these are hints for people and no errors.
"""

from collections.abc import AsyncIterator, Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import replace
from itertools import chain
from typing import Final, TypeVar, final

from homebot.command_words.targets import CommandTargets, NoTargetError, Target
from homebot.devices import QUERY_DEVICES, Device, DevicePart, KeyValue, QueryDevices
from homebot.devices.capabilities import EVENTS
from homebot.devices.command_messages import CommandDevicesRequest
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import LIST_SCENES
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.term_messages import query_terms, query_words, read_terms
from homebot.devices.query.terms import Query, StateIs, lasting, leaves
from homebot.devices.scene_messages import ListScenes, ScenesRequest
from homebot.devices.services import QueryDevicesRequest, QueryDevicesResponse
from homebot.errors import HomebotError, RefusedError, ServiceError, UsageError
from homebot.features.routines.effects import Effect, RoutineEffects, fights, loops
from homebot.features.routines.program import ForEach, program_of
from homebot.features.routines.settings import RoutineSettings
from homebot.features.routines.tables import app_of_routine
from homebot.graph import Node
from homebot.support.folding import fold
from homebot.words.commands import is_relative
from homebot.words.conditions import Condition, HouseSpan, Matches, SinceMoment, read_condition
from homebot.words.message_values import Comparison, MessageValue
from homebot.words.queries import names_in, parse_query
from homebot.words.steps import APPLY, Dim, Do, SendRobot, Wait, WaitFor, WaitUntil
from homebot.words.suitable_parts import part_name, settings_by_part
from homebot.words.tokens import quoted
from homebot.words.triggers import (
    AtTimeOf,
    Becomes,
    Changes,
    PersonMoves,
    Press,
    RobotArrival,
    Trigger,
    ValuePasses,
    button_names,
    read_trigger,
)

_MAX_DEVICES: Final = 200
"""Devices with events that are compared with that of a trigger."""
_MAX_NAMED: Final = 3
_UNTIL: Final = "wait until "
_BUSY: Final = {"clear": "occupied", "unoccupied": "occupied", "off": "on", "closed": "open", "dry": "wet"}
"""Words for the rest of a device, each with that for the contrary."""

_AskedT = TypeVar("_AskedT", Trigger, Condition)


@final
class HouseChecks:
    """Checks routines against the directory.

    Args:
        refusal: Returns why an effect of the app of a routine is refused, empty if it is not, and the right that it
            lacks, as a query.
        with_robots: Whether robots that are missing are problems.
    """

    def __init__(
        self, node: Node, refusal: Callable[[str, Effect], tuple[str, str]], *, with_robots: bool = True
    ) -> None:
        self._node = node
        self._refusal = refusal
        self._with_robots = with_robots
        self._lookup = DeviceLookup(node)
        self._targets = CommandTargets(node, self._lookup, lambda *_: "")
        self._query = node.create_client(QueryDevices, QUERY_DEVICES)
        self._answers: dict[tuple[str, int], QueryDevicesResponse] = {}
        self._targeted: dict[Do, list[Target]] = {}
        self._meanings: dict[str, Query] = {}

    async def problems(
        self,
        routines: Iterable[RoutineSettings],
        names: Collection[str] = (),
        lacking: dict[str, list[str]] | None = None,
    ) -> Mapping[str, list[str]]:
        """Return the problems of each of *routines*, by its name; none if the directory does not answer.

        Args:
            names: Those that are asked about, which costs far less; empty for all.
            lacking: Filled with the rights that each lacks, as queries.
        """
        settings = {routine.name: routine for routine in routines}
        as_written = {
            name: (tuple(map(read_trigger, routine.when)), tuple(map(read_condition, routine.conditions)))
            for name, routine in settings.items()
            if names and routine.enabled
        }
        problems: dict[str, list[str]] = {}
        known: list[RoutineEffects] = []
        self._forget()
        asked = names or settings
        waiting = [name for name in settings if name in asked]
        try:
            for name in waiting:  # which grows by those that they concern
                effects: list[Effect] = []
                problems[name] = [problem async for problem in self._of(settings[name], effects)]
                problems[name] += self._refused(name, effects, lacking)
                if settings[name].enabled:
                    known.append(await self._resolved_effects(settings[name], effects))
                    others = [other for other in as_written if other not in waiting]
                    written = RoutineEffects(name, *as_written.get(name, ((), ())), tuple(effects))
                    waiting += [
                        other for other in others if written.concerns(RoutineEffects(other, *as_written[other], ()))
                    ]
        except ServiceError:
            return {}
        for name, problem in (*loops(known), *fights(known)):
            problems[name].append(problem)
        return {name: [*dict.fromkeys(problems[name])] for name in problems if problems[name] and name in asked}

    def _refused(self, routine: str, effects: Iterable[Effect], lacking: dict[str, list[str]] | None) -> Iterator[str]:
        """Yield which *effects* the app of *routine* may not have, and add the rights that it lacks."""
        for effect in effects:
            reason, right = self._refusal(app_of_routine(routine), effect)
            if reason:
                yield f"{effect.text!r} is refused: {reason}"
            if right and lacking is not None:
                lacking.setdefault(routine, []).append(right)

    async def _resolved_effects(self, routine: RoutineSettings, effects: Sequence[Effect]) -> RoutineEffects:
        """Return *effects* with the triggers and conditions of *routine* as the house understands their words."""
        conditions = tuple([await self._resolved(read_condition(text)) for text in routine.conditions])
        triggers = tuple([await self._resolved(read_trigger(text)) for text in routine.when])
        return RoutineEffects(routine.name, triggers, conditions, tuple(effects))

    async def commanding(self, routines: Iterable[RoutineSettings], device: str) -> frozenset[str]:
        """Return the names of those of *routines* that command the device with the id *device*."""
        self._forget()
        return frozenset(
            [one.name for one in routines if any(effect.device.id == device for effect in await self._effects(one))]
        )

    async def effects(self, routine: RoutineSettings) -> Sequence[Effect]:
        """Return the values that the steps of *routine* set."""
        self._forget()
        return await self._effects(routine)

    async def named(self, query: str) -> str:
        """Return the names of the devices that *query* finds; *query* itself if these are many, or none."""
        with suppress(UsageError):
            asked = QueryDevicesRequest(query=query_terms(parse_query(query)), limit=_MAX_NAMED + 1)
            devices = [result.device for result in (await self._query.call(asked)).results]
            if 0 < len(devices) <= _MAX_NAMED:
                return ", ".join(device.name or device.id for device in devices)
        return query

    def _forget(self) -> None:
        self._answers.clear()
        self._targeted.clear()
        self._meanings.clear()

    async def may_repeat(self, step: Do) -> bool:
        """Return whether to take *step* twice is known to be the same as once."""
        effects: list[Effect] = []
        self._targeted.clear()
        try:
            await self._command(step, effects, step.text, is_prompt=True)
        except ServiceError:
            return False
        return bool(effects) and not _is_change(step) and not any(effect.acts_each_time for effect in effects)

    async def _effects(self, routine: RoutineSettings) -> list[Effect]:
        effects: list[Effect] = []
        async for _ in self._of_steps(routine, effects):
            pass
        return effects

    async def _of(self, routine: RoutineSettings, effects: list[Effect]) -> AsyncIterator[str]:
        """Yield the problems of one routine, and add the effects of its steps to *effects*."""
        for text, asked, press in _states(routine):
            query = await self._meant("" if isinstance(asked, PersonMoves) else asked.words, asked.query)
            if problem := (
                await self._problem_of(query)
                or (press and await self._unknown_event(replace(press, query=query)))
                or await self._others(text, query)
                or (isinstance(asked, Becomes) and await self._one_suffices(asked, query))
            ):
                yield f"{text!r}: {problem}"
        for text, move in _moves(routine):
            if problem := await self._move(move):
                yield f"{text!r}: {problem}"
        async for problem in self._of_steps(routine, effects):
            yield problem

    async def _of_steps(self, routine: RoutineSettings, effects: list[Effect]) -> AsyncIterator[str]:
        is_prompt = True
        for line in program_of(routine.do):
            match line.step:
                case ForEach(devices=devices):
                    if problem := await self._problem_of(await self._meant(devices, parse_query(devices))):
                        yield f"for each {devices}: {problem}"
                case Do(pieces=(_, *_)) as step:
                    if problem := await self._problem_of(await self._meant(step.target, parse_query(step.target))):
                        yield f"{line.text!r}: {problem}"
                case Do() as step:
                    for problem in await self._command(step, effects, line.text, is_prompt=is_prompt):
                        yield f"{line.text!r}: {problem}"
                case Dim() as step:
                    if problem := await self._problem_of(await self._meant(step.target, step.query)):
                        yield f"{line.text!r}: {problem}"
                case Wait() | WaitFor() | WaitUntil():
                    is_prompt = False

    async def _meant(self, words: str, query: Query) -> Query:
        """Return *query*, written as *words*, in which those that are exactly a name mean what is called so."""
        if words and words not in self._meanings:
            answer = await self._query.call(QueryDevicesRequest(query=query_words(words), limit=1))
            self._meanings[words] = read_terms(answer.query) if answer.query else query
        return self._meanings[words] if words else query

    async def _resolved(self, asked: _AskedT) -> _AskedT:
        match asked:
            case AtTimeOf() | Becomes() | Changes() | Press():
                return replace(asked, query=await self._meant(asked.words, asked.query))
            case Matches(state=state):
                return replace(asked, state=replace(state, query=await self._meant(state.words, state.query)))
            case _:
                return asked

    async def _problem_of(self, query: Query) -> str:
        """Return why no device of the house can match *query*, in any state; empty if one can."""
        answer = await self._ask(query)
        if answer.is_mistake:
            return answer.message
        if answer.total:
            return ""
        answer = await self._ask(lasting(query))
        return (
            "" if answer.total else answer.message or "nothing in the house fits this; `homebot find` shows what does"
        )

    async def _unknown_event(self, press: Press) -> str:
        """Return that no device that fits has the button, or tells of the event, of *press*; empty if one may."""
        devices = [one.device for one in (await self._ask(press.query, _MAX_DEVICES)).results]
        parts = [[part for part in device.parts if _has_events(part)] for device in devices]
        buttons = [*chain.from_iterable(map(press.buttons, parts))]
        if any(parts) and not buttons:
            names = dict.fromkeys(chain.from_iterable(map(button_names, parts)))
            return f"it has no button {press.part!r}; it has {', '.join(names)}"
        options = [option for one in buttons for can in one.part.capabilities for option in can.options]
        if not press.value or not options or press.value in map(str.casefold, options):
            return ""
        return f"it has no event {press.value!r}; it has {', '.join(dict.fromkeys(options))}"

    async def _others(self, text: str, query: Query) -> str:
        """Return that *query* means others as well, if *text* begins with the name of one device, as in a command."""
        devices = [one.device for one in (await self._ask(lasting(query), _MAX_DEVICES)).results]
        begin = f"{fold(text.removeprefix(_UNTIL))} "
        named = [one for one in devices if one.name and begin.startswith(f"{fold(one.name)} ")]
        if len(named) != 1 or len(devices) == 1:
            return ""
        others = ", ".join([one.name or one.id for one in devices if one != named[0]][:_MAX_NAMED])
        return f"this is about {others} as well; for {named[0].name} alone begin with name={quoted(named[0].name)}"

    async def _one_suffices(self, state: Becomes, query: Query) -> str:
        """Return that the rest of one of several devices is enough for *state*, with the text for all of them."""
        words, _, length = state.text.rpartition(" for ")
        parts = words.split(" ")
        place = next((at for at, part in enumerate(parts) if part.casefold() in _BUSY), None)
        if place is not None:
            parts[place] = _BUSY[parts[place].casefold()]
        busy = " ".join(parts)
        if not state.lasting or state.is_none or busy == words:
            return ""
        devices = [one.device.name or one.device.id for one in (await self._ask(lasting(query), _MAX_DEVICES)).results]
        if len(devices) <= 1:
            return ""
        named = f"{' or '.join(devices[:_MAX_NAMED])}{', …' if len(devices) > _MAX_NAMED else ''}"
        return f"one of {named} suffices; for all of them write 'no {busy} for {length}'"

    async def _command(self, step: Do, effects: list[Effect], text: str, *, is_prompt: bool) -> list[str]:
        """Return why *step*, written as *text*, cannot be carried out, and add its effects."""
        if step.command == APPLY:
            return await self._scene(step, effects, text, is_prompt=is_prompt)
        is_toggled = step.command.casefold() == "toggle"
        request = CommandDevicesRequest(
            target=step.target,
            command="on" if is_toggled else step.command,
            values=tuple(KeyValue(key=name, value=value) for name, value in step.values),
        )
        try:
            if step not in self._targeted:
                self._targeted[step] = await self._targets.find(request)
            targets = self._targeted[step]
        except NoTargetError as exc:
            return [*filter(None, [await self._why_none(step.target, str(exc))])]
        except UsageError as exc:
            return [str(exc)]
        refused, taken = [], 0
        for device, parts in targets:
            for part, parsed in settings_by_part(request, device, parts):
                if isinstance(parsed, RefusedError):
                    refused.append(f"{part_name(device, part)}: {parsed.reason}")
                    continue
                taken += 1
                results = (parsed, dict.fromkeys(parsed, False)) if is_toggled else (parsed,)
                may_be = is_toggled or _is_change(step)
                effects += [Effect(text, device, part.id, result, is_prompt, may_be) for result in results]
        return refused if len(targets) <= 1 or not taken else []

    async def _scene(self, step: Do, effects: list[Effect], text: str, *, is_prompt: bool) -> list[str]:
        """Return why the scene of *step* is unknown, and add the effects of its known values."""
        with closing(self._node.create_client(ListScenes, LIST_SCENES)) as client:
            answer = await client.call(ScenesRequest(name=step.target.partition(" ")[2]))
        devices = {one.id: one for one in await self._lookup.devices()} if answer.scenes else {}
        for part in (part for scene in answer.scenes for part in scene.parts):
            if part.settings and part.device in devices:
                settings = {one.capability: one.value.plain() for one in part.settings}
                effects.append(Effect(text, devices[part.device], part.part, settings, is_prompt))
        return [] if answer.success else [answer.message]

    async def _why_none(self, target: str, problem: str) -> str:
        """Return *problem* unless the target is a state, such as 'open windows', that is only missing now."""
        query = parse_query(target)
        if any(isinstance(one, StateIs) for one in leaves(query)):
            return await self._problem_of(query)
        return problem

    async def _move(self, move: SendRobot | RobotArrival) -> str:
        """Return why no robot can move so; empty if one can."""
        from homebot.robots.drive import check_move  # noqa: PLC0415 - few homes have a robot

        if not self._with_robots:
            return ""
        try:
            await check_move(self._node, move)
        except HomebotError as exc:
            return str(exc)
        return ""

    async def _ask(self, query: Query, limit: int = 1) -> QueryDevicesResponse:
        key = repr(query), limit  # many routines ask for the same
        if key not in self._answers:
            self._answers[key] = await self._query.call(
                QueryDevicesRequest(query=query_terms(query), limit=limit, is_spelled=True)
            )
        return self._answers[key]


def _states(
    routine: RoutineSettings,
) -> Iterator[tuple[str, AtTimeOf | Becomes | Changes | MessageValue | PersonMoves | Press, Press | None]]:
    """Yield the text of each state, compared value and press, with what it asks for."""
    for text, one in routine.asked():
        match one:
            case (AtTimeOf() | Becomes() | Changes() | PersonMoves()) as state:
                yield text, state, None
                length = state.length if isinstance(state, Becomes) else None
                yield from ((text, value, None) for value in (length.asked if length else ()))
            case HouseSpan():
                yield from ((text, end, None) for end in (one.begin, one.end) if isinstance(end, MessageValue))
            case SinceMoment(moment=moment):
                yield text, moment, None
            case Matches(state=state):
                yield text, state, None
            case Press() as press:
                yield text, press, press
            case ValuePasses(comparison=comparison) | (Comparison() as comparison):
                values = (*comparison.first.asked, *comparison.second.asked)
                yield from ((text, value, None) for value in values if value.words)


def _moves(routine: RoutineSettings) -> Iterator[tuple[str, SendRobot | RobotArrival]]:
    """Yield the text of each trigger and step that is about a robot, with its meaning."""
    for text in routine.when:
        if isinstance(trigger := read_trigger(text), RobotArrival):
            yield text, trigger
    for line in program_of(routine.do):
        if isinstance(line.step, SendRobot):
            yield line.step.text, line.step


def asked_about(routines: Iterable[RoutineSettings]) -> Callable[[Device], bool]:
    """Return the test for devices with states that *routines* ask for, or that they command."""
    queries: list[Query] = []
    names: set[str] = set()
    for one in routines:
        for _, asked, _ in _states(one):
            queries.append(lasting(asked.query))
            names.update(() if isinstance(asked, PersonMoves) else names_in(asked.words))
        for line in program_of(one.do):
            if isinstance(line.step, Do | Dim | ForEach):
                words = line.step.devices if isinstance(line.step, ForEach) else line.step.target
                names.add(fold(words))
                with suppress(UsageError):
                    queries.append(lasting(parse_query(words)))

    def is_meant(device: Device) -> bool:
        is_named = not names.isdisjoint(map(fold, (device.id, *device.names)))
        return is_named or any(fits(query, facets_of(device)) for query in queries)

    return is_meant


def _is_change(step: Do) -> bool:
    """Return whether a word of *step* changes a value, such as ``brighter``."""
    return any(map(is_relative, (step.command, *[value for _, value in step.values])))


def _has_events(part: DevicePart) -> bool:
    return any(one.name in EVENTS for one in part.part.capabilities)
