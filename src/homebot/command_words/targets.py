"""Targets of a command in words: devices and their parts."""

import math
from collections.abc import Awaitable, Callable, Collection
from itertools import chain
from typing import Final, NamedTuple, TypeAlias, final

from homebot.devices import QUERY_DEVICES, Device, DevicePart, QueryDevices
from homebot.devices.command_messages import CommandDevicesRequest
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.device_names import ask_which, is_called, names_of
from homebot.devices.names import GROUP
from homebot.devices.outcomes import no_such_part
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.term_messages import query_words, read_terms
from homebot.devices.query.terms import And, CanDo, FactIs, HasText, Query, StateIs, TypeIs, leaves, split_near
from homebot.devices.services import QueryDevicesRequest, QueryDevicesResponse
from homebot.errors import RefusedError
from homebot.graph import Node
from homebot.support.folding import fold, words_of
from homebot.support.names import close_names, spellings
from homebot.words.phrases import EVERYTHING
from homebot.words.queries import parse_query
from homebot.words.readings import Readings, readings_of
from homebot.words.suitable_parts import controls, part_name, settings_by_part, takes
from homebot.words.tokens import split_at

MAX_DEVICES: Final = 1000
"""Devices that one command may be for."""

Target: TypeAlias = tuple[Device, tuple[DevicePart, ...]]


class NoTargetError(Exception):
    """There is nothing to command; the text says why."""


class _TargetPhrase(NamedTuple):
    """Words for devices: a whole target, or one of its alternatives."""

    request: CommandDevicesRequest
    text: str
    query: Query
    is_alternative: bool


class _Matches(NamedTuple):
    """Devices and parts that a search found.

    Attributes:
        question: What is asked instead of a command to *targets*; empty if they are clear.
    """

    targets: list[Target]
    question: str = ""


@final
class CommandTargets:
    """Search for the targets of a command in words.

    Args:
        refusal: Returns why a target would be refused the command now; empty if it would not.
    """

    def __init__(
        self, node: Node, lookup: DeviceLookup, refusal: Callable[[CommandDevicesRequest, Target], str]
    ) -> None:
        self._lookup = lookup
        self._refusal = refusal
        self._query = node.create_client(QueryDevices, QUERY_DEVICES)
        # In order; whether what is found is meant, even if it does not take the command.
        self._searches: tuple[tuple[Callable[[_TargetPhrase], Awaitable[_Matches]], bool], ...] = (
            (self._called, True),
            (self._nearest, True),
            (self._part_worded, True),
            (self._fitting, False),
            (self._part_called, False),
        )

    async def find(self, request: CommandDevicesRequest) -> list[Target]:
        """Return the targets, each a device with its parts.

        Left out are buttons of that name if something else takes the command, and of everything what does not take it.

        Raises:
            NoTargetError: There is no target, there are too many, or several devices have the name.
            UsageError: The target is not a query.
            ServiceError: The directory does not answer.
        """
        targets = _without_groups(await self._find(request, request.target.strip()))
        taken = {
            (device.id, part.id): parsed != {"push": True}
            for device, parts in targets
            for part, parsed in settings_by_part(request, device, parts)
            if not isinstance(parsed, RefusedError)
        }
        if len(set(taken.values())) <= 1 and not (taken and EVERYTHING.match(request.target)):
            return targets
        kept = [(device, tuple(part for part in parts if taken.get((device.id, part.id)))) for device, parts in targets]
        return [target for target in kept if target[1]]

    async def _find(self, request: CommandDevicesRequest, target: str) -> list[Target]:
        if not target:
            raise NoTargetError("give the id or the name of a device, or a query such as 'light in hall'")
        named = await self._called(_TargetPhrase(request, target, And(()), is_alternative=False))
        if targets := _clear(named) or await self._read(request, target):
            return targets
        names = {name for device in await self._lookup.devices() for name in names_of(device)}
        joined = "join devices with 'or'" if len(split_at(target, "and", ",")) > 1 else "`homebot find` shows what does"
        raise NoTargetError(f"no device fits {target!r}; {close_names(target, names, joined)}")

    async def _read(self, request: CommandDevicesRequest, target: str) -> list[Target]:
        """Return the targets according to the query *target*; an ambiguous one is an error."""
        readings = readings_of(target)
        texts = readings.alternatives if len(readings.alternatives) > 1 else (target,)
        targets, unnamed = await self._any_of(request, texts, readings.words)
        others, _ = await self._any_of(request, readings.distributed)
        return _clear(_Matches(targets, _question(target, readings, targets, others, unnamed)))

    async def _any_of(
        self, request: CommandDevicesRequest, texts: Collection[str], words: Collection[str] = ()
    ) -> tuple[list[Target], list[str]]:
        """Return the targets that fit any of *texts*, and those of *texts* that are no name or fit no device."""
        by_id: dict[str, tuple[Device, dict[str, DevicePart]]] = {}
        unnamed: list[str] = []
        for text in texts:
            query = parse_query(text)
            targets, is_named = await self._search(_TargetPhrase(request, text, query, is_alternative=len(texts) > 1))
            if not (is_named if text in words else targets or text.startswith("(") or not _texts(query)):
                unnamed.append(text)
            for device, parts in targets:
                by_id.setdefault(device.id, (device, {}))[1].update({part.id: part for part in parts})
        return [(device, tuple(parts.values())) for device, parts in by_id.values()], unnamed

    async def _search(self, phrase: _TargetPhrase) -> tuple[list[Target], bool]:
        """Return what the first search finds that is meant, and whether it is meant whatever the command."""
        best = _Matches([])
        for search, is_sure in self._searches if phrase.is_alternative else self._searches[1:]:  # it is no name
            matches = await search(phrase)
            if matches.targets and (is_sure or any(takes(phrase.request, target) for target in matches.targets)):
                return _clear(matches), is_sure
            best = best if best.targets else matches
        return _clear(best), False

    async def _called(self, phrase: _TargetPhrase) -> _Matches:
        """Find the device, its part, or the group that has the id or name."""
        request, text = phrase.request, phrase.text
        device_id, _, part_id = text.partition("#")
        called = await self._lookup.find_called(text, device_id)
        if part_id and called and called[0].id.casefold() == device_id.casefold():
            if (part := called[0].part(part_id)) is None:
                raise NoTargetError(no_such_part(called[0].id, part_id, called[0]).text)
            return _Matches([(called[0], (part,))])
        for name in spellings(text):
            if len(called) > 1 and is_called(called[0], name):
                return _Matches([(device, device.parts) for device in called], ask_which(name, called))
            if called and is_called(called[0], name):
                members = await self._of_native_group(request, called[0])
                return members or _parts_called(request, called[0], name)
            group = FactIs(GROUP, fold(name))
            if grouped := await self._lookup.devices(group):
                return _Matches([(device, _parts(device, group)) for device in grouped])
        return _Matches([])

    async def _of_native_group(self, request: CommandDevicesRequest, device: Device) -> _Matches | None:
        """Find the members of a group that a gateway knows as the device; None for any other, or if none takes it."""
        by_id: dict[str, tuple[Device, dict[str, DevicePart]]] = {}
        for part in device.parts:
            for member, its_part in await self._lookup.members(device, part) if part.part.is_group else ():
                by_id.setdefault(member.id, (member, {}))[1][its_part.id] = its_part
        members = [(member, tuple(parts.values())) for member, parts in by_id.values()]
        return _Matches(members) if any(takes(request, target) for target in members) else None

    async def _part_worded(self, phrase: _TargetPhrase) -> _Matches:
        """Find a part by its name, unless that is only a type or a condition."""
        return await self._part_called(phrase) if _texts(phrase.query) else _Matches([])

    async def _part_called(self, phrase: _TargetPhrase) -> _Matches:
        """Find the parts of a device that are called so, such as one of four relays; if possible, one that takes it."""
        words, name = words_of(phrase.text), fold(phrase.text)
        devices = await self._lookup.devices(And(tuple(map(HasText, words)))) if words else ()
        called = [
            (device, tuple(part for part in controls(device.parts) if _is_called(device, part, name)))
            for device in devices
        ]
        matching = [target for target in called if takes(phrase.request, target)] or [
            target for target in called if target[1]
        ]
        ids = ", ".join(f"{device.id}#{parts[0].id}" for device, parts in matching[:10])
        question = f"{len(matching)} devices have a part called {phrase.text}; give the id of one: {ids}"
        return _Matches(matching, question if len(matching) > 1 else "")

    async def _nearest(self, phrase: _TargetPhrase) -> _Matches:
        """Find the nearest target that may be commanded; if none may, the error names the nearest and the reasons."""
        near, _ = split_near(phrase.query)
        if near is None or not math.isinf(near.within):
            return _Matches([])
        answer = await self._ask(phrase.text, _MAX_NEAR)
        rest = split_near(read_terms(answer.query))[1]
        refused = [f"{item.key}: {item.value}" for item in answer.left_out]
        for device in [result.device for result in answer.results if fits(rest, facets_of(result.device))]:
            target = device, _parts(device, rest)
            if not (problem := self._refusal(phrase.request, target)):
                return _Matches([target])
            refused.append(f"{device.name}: {problem}")
        if refused:
            raise NoTargetError(f"nothing near {near.robot} may be commanded; left out: {'; '.join(refused)}")
        return _Matches([])

    async def _fitting(self, phrase: _TargetPhrase) -> _Matches:
        """Find the devices that fit the query, and their parts that do; words alone mean one device."""
        text = phrase.text
        answer = await self._ask(text, MAX_DEVICES)
        if answer.total > MAX_DEVICES:
            raise NoTargetError(f"{answer.total:,} devices fit {text!r}; at most {MAX_DEVICES:,} may be commanded")
        if not answer.total and (near := (await self._ask(text, _MAX_SIMILAR, is_spelled=False)).results):
            similar = " or ".join(result.device.name or result.device.id for result in near)
            raise NoTargetError(f"no device fits {text!r}; did you mean {similar}?")
        query, devices = read_terms(answer.query), [result.device for result in answer.results]
        numbers = {word for word in _texts(query) if word.isdecimal()}  # a room may have a number too
        devices = [device for device in devices if numbers <= _called(device)] or devices
        targets = [(device, _parts(device, query)) for device in devices]
        if len(targets) < 2 or phrase.is_alternative or not _names_one(query):
            return _Matches(targets)
        return _Matches(targets, f"{text!r} could be {_names(targets)}; give the name of one, or a type")

    async def _ask(self, text: str, limit: int, *, is_spelled: bool = True) -> QueryDevicesResponse:
        request = QueryDevicesRequest(query=query_words(text), limit=limit, is_spelled=is_spelled)
        answer = await self._query.call(request)
        if not answer.success:
            raise NoTargetError(answer.message)
        return answer


_MAX_NAMES = 8
_MAX_SIMILAR = 3

_MAX_NEAR = 10
"""The number of nearest devices that are tried."""


def _names_one(query: Query) -> bool:
    """Return whether *query* is of words alone, which mean one device."""
    return bool(_texts(query)) and not any(isinstance(term, TypeIs | CanDo | StateIs) for term in leaves(query))


def _without_groups(found: list[Target]) -> list[Target]:
    """Return *found* without the groups of gateways, unless there is nothing else: their members are found too."""
    return [target for target in found if not any(part.part.is_group for part in target[1])] or found


def _clear(found: _Matches) -> list[Target]:
    if found.question:
        raise NoTargetError(found.question)
    return found.targets


def _question(target: str, readings: Readings, found: list[Target], others: list[Target], unnamed: list[str]) -> str:
    """Return what is asked if *target* may mean *others*, as distributed, instead of *found*; empty if it may not."""
    is_list = len(readings.alternatives) == 1
    listed = f"{' or '.join(readings.distributed)!r}, which commands {_names(others)}"
    literal = f"{' or '.join(f'({text})' for text in readings.alternatives)!r}, which commands {_names(found)}"
    if (others if is_list else readings.distributed) and _places(others) != _places(found):
        if not is_list:
            return f"{target!r} can mean {listed}, or {literal}; give one of them"
        if found:
            return f"{target!r} can mean {listed}, or what fits all of it, {_names(found)}; name the one you mean"
        return f"no device fits {target!r}; join devices with 'or': {listed}"
    if unnamed and found and not (is_list or readings.distributed):
        return f"{unnamed[0]!r} in {target!r} is not the name of a device; give names, or {literal}"
    is_several = len(_places(found)) > 1 and target.casefold().startswith(("a ", "an "))
    return f"{target!r} could be {_names(found)}; give the name of one" if is_several else ""


def _places(targets: list[Target]) -> frozenset[tuple[str, str]]:
    return frozenset((device.id, part.id) for device, parts in targets for part in parts)


def _names(targets: list[Target]) -> str:
    names = sorted(part_name(device, part) for device, parts in targets for part in parts)
    more = f" and {len(names) - _MAX_NAMES} more" if len(names) > _MAX_NAMES else ""
    return f"{', '.join(names[:_MAX_NAMES])}{more}" or "nothing"


def _is_called(device: Device, part: DevicePart, name: str) -> bool:
    return name in {fold(part.part.name), fold(f"{device.name} {part.part.name}")}  # the second as homebot prints it


def _called(device: Device) -> set[str]:
    """Return the words of the id and the names of *device*."""
    return set(chain.from_iterable(map(words_of, names_of(device))))


def _main_parts(device: Device) -> tuple[DevicePart, ...]:
    """Return the main parts that take commands; if there are none, any one part, which refuses the command."""
    if not device.parts:
        raise NoTargetError(f"{device.id} takes no commands that homebot knows")
    return controls(device.parts) or device.parts[:1]


def _parts_called(request: CommandDevicesRequest, device: Device, name: str) -> _Matches:
    """Return the only part of *device* called *name*, as of a bridge that gives each part a device's name; or else all.

    The name of a device and of one part among others that take the command is ambiguous.
    """
    parts, question = _main_parts(device), ""
    named = [part for part in parts if fold(part.part.name) == fold(name)]
    if len(named) == 1 < len(parts) and not (request.target == device.id != device.name):
        names = set(map(fold, device.names))
        able = [
            part for part, parsed in settings_by_part(request, device, parts) if not isinstance(parsed, RefusedError)
        ]
        if fold(name) != fold(device.name) or names.issuperset(fold(part.part.name) for part in able):
            parts = tuple(named)
        elif named[0] in able and len(able) > 1:
            ids = ", ".join(f"{device.id}#{part.id}" for part in able[:_MAX_NAMES])
            question = f"{name!r} could be {_names([(device, tuple(able))])}; give the id of one: {ids}"
    return _Matches([(device, parts)], question)


def _parts(device: Device, query: Query) -> tuple[DevicePart, ...]:
    """Return the main parts that fit the query by themselves, or all if none does.

    A word that occurs in the names of parts, but not in those of the device, selects these parts.
    """
    main = _main_parts(device)
    meant = [part for part in main if fits(query, PartFacets(device, part))] or list(main)
    called = _called(device).union(*map(words_of, (device.area, *device.tags)))
    for word in _texts(query):
        if not any(name.startswith(word) for name in called):
            named = [part for part in meant if any(own.startswith(word) for own in words_of(part.part.name))]
            meant = named or meant
    return tuple(meant)


def _texts(query: Query) -> tuple[str, ...]:
    """Return the words that a device must have."""
    terms = query.terms if isinstance(query, And) else (query,)
    return tuple(term.text for term in terms if isinstance(term, HasText))
