"""Targets of a command in words: devices and their parts."""

import math
import re
from collections.abc import Callable, Collection, Iterable
from itertools import chain
from typing import Final, TypeAlias, final

from homebot.command_words.suitable_parts import controls, part_name, settings_by_part, takes
from homebot.devices import QUERY_DEVICES, Device, DevicePart, QueryDevices
from homebot.devices.command_messages import CommandDevicesRequest
from homebot.devices.device_lookup import DeviceLookup, ask_which
from homebot.devices.outcomes import no_such_part
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.parse import parse_query
from homebot.devices.query.readings import Readings, readings_of
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import And, CanDo, HasText, IsNear, Or, Query, StateIs, TypeIs, leaves, split_near
from homebot.devices.services import QueryDevicesRequest
from homebot.errors import RefusedError
from homebot.graph import Node
from homebot.support.folding import fold, words_of
from homebot.support.similar import did_you_mean

__all__ = [
    "MOST_DEVICES",
    "CommandTargets",
    "NoTargetError",
    "Target",
]

MOST_DEVICES: Final = 1000
"""Devices that one command may be for."""

_TYPO: Final = 0.8
"""How similar a name must be to be suggested."""

Target: TypeAlias = tuple[Device, tuple[DevicePart, ...]]


class NoTargetError(Exception):
    """There is nothing to command; the text says why."""


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

    async def find(self, request: CommandDevicesRequest) -> list[Target]:
        """Return the targets, each a device with its parts.

        Left out are buttons of that name if something else takes the command, and of everything what does not take it.

        Raises:
            NoTargetError: There is no target, there are too many, or several devices have the name.
            UsageError: The target is not a query.
            ServiceError: The directory does not answer.
        """
        found = await self._find(request, request.target.strip())
        taken = {
            (device.id, part.id): parsed != {"push": True}
            for device, parts in found
            for part, parsed in settings_by_part(request, device, parts)
            if not isinstance(parsed, RefusedError)
        }
        if len(set(taken.values())) <= 1 and not (taken and _EVERYTHING.match(request.target)):
            return found
        kept = [(device, tuple(one for one in parts if taken.get((device.id, one.id)))) for device, parts in found]
        return [one for one in kept if one[1]]

    async def _find(self, request: CommandDevicesRequest, target: str) -> list[Target]:
        if not target:
            raise NoTargetError("give the id or the name of a device, or a query such as 'light in hall'")
        if named := await self._named(request, target):
            return named
        readings = readings_of(target)
        is_list = len(readings.alternatives) == 1 and bool(readings.distributed)
        found = await (self._listed if is_list else self._any_of)(request, target, readings)
        if not found:
            names = {name for one in await self._lookup.devices() for name in (one.id, *one.names)}
            joined = "join devices with 'or'" if _JOINED.search(target) else "`homebot find` shows what does"
            hint = did_you_mean(_ARTICLE.sub(r"\1", target), names, joined, _TYPO)
            raise NoTargetError(f"no device fits {target!r}; {hint}")
        if len(_places(found)) > 1 and _ONE.match(target):
            raise NoTargetError(f"{target!r} could be {_names(found)}; give the name of one")
        return found

    async def _named(self, request: CommandDevicesRequest, target: str) -> list[Target]:
        """Return the device, or its part, that has the id or name *target*, perhaps quoted or with an article."""
        spelled = _ARTICLE.fullmatch(target) or _QUOTED.fullmatch(target)
        called = await self._called(request, target)
        return called or (await self._called(request, spelled[1]) if spelled is not None else [])

    async def _called(self, request: CommandDevicesRequest, target: str) -> list[Target]:
        device_id, _, part_id = target.partition("#")
        called = await self._lookup.called(target, device_id)
        if part_id and called and called[0].id.casefold() == device_id.casefold():
            if (part := called[0].part(part_id)) is None:
                raise NoTargetError(no_such_part(called[0].id, part_id, called[0]).text)
            return [(called[0], (part,))]
        if len(called) > 1:
            raise NoTargetError(ask_which(target, called))
        return [(called[0], _parts_called(request, called[0], target))] if called else []

    async def _any_of(self, request: CommandDevicesRequest, target: str, readings: Readings) -> list[Target]:
        """Return the targets that fit any alternative of the query *target*; an ambiguous one is an error."""
        if len(readings.alternatives) == 1:
            return await self._one_query(request, target)
        found, unnamed = await self._all_of(request, readings.alternatives, readings.words)
        spelled = " or ".join(f"({text})" for text in readings.alternatives)
        literal = f"{spelled!r}, which commands {_names(found)}"
        if readings.distributed:
            others, _ = await self._all_of(request, readings.distributed)
            if _places(others) == _places(found):
                return found
            distributed = " or ".join(readings.distributed)
            raise NoTargetError(
                f"{target!r} can mean {distributed!r}, which commands {_names(others)}, or {literal}; give one of them"
            )
        if unnamed and found:
            raise NoTargetError(f"{unnamed[0]!r} in {target!r} is not the name of a device; give names, or {literal}")
        return found

    async def _listed(self, request: CommandDevicesRequest, target: str, readings: Readings) -> list[Target]:
        """Return the targets that fit all of *target*, unless it can also be read as a list; see :meth:`_any_of`."""
        others, _ = await self._all_of(request, readings.distributed)
        try:
            found = await self._one_query(request, target)
        except NoTargetError:
            found = []
            if not others:
                raise
        if not others or _places(others) == _places(found):
            return found
        listed = f"{' or '.join(readings.distributed)!r}, which commands {_names(others)}"
        if not found:
            raise NoTargetError(f"no device fits {target!r}; join devices with 'or': {listed}")
        raise NoTargetError(
            f"{target!r} can mean {listed}, or what fits all of it, {_names(found)}; name the one you mean"
        )

    async def _all_of(
        self, request: CommandDevicesRequest, alternatives: Iterable[str], words: Collection[str] = ()
    ) -> tuple[list[Target], list[str]]:
        """Return the targets that fit any of *alternatives*, and the alternatives that are no name or fit no device."""
        found: dict[str, tuple[Device, dict[str, DevicePart]]] = {}
        unnamed: list[str] = []
        for text in alternatives:
            targets, is_named = await self._alternative(request, text, is_words=text in words)
            if not is_named:
                unnamed.append(text)
            for device, parts in targets:
                found.setdefault(device.id, (device, {}))[1].update({one.id: one for one in parts})
        return [(device, tuple(parts.values())) for device, parts in found.values()], unnamed

    async def _alternative(
        self, request: CommandDevicesRequest, text: str, *, is_words: bool
    ) -> tuple[list[Target], bool]:
        """Return the targets that fit one alternative, and False if its words are not a name or fit no device."""
        named = await self._named(request, text) or (await self._named_part(text) if is_words else [])
        targets = named or await self._one_query(request, text, is_alternative=True)
        if is_words:
            return targets, bool(named)
        return targets, bool(targets) or text.startswith("(") or not _texts(parse_query(text))

    async def _one_query(
        self, request: CommandDevicesRequest, text: str, *, is_alternative: bool = False
    ) -> list[Target]:
        near, rest = split_near(parse_query(text))
        if near is not None and math.isinf(near.within):
            return await self._nearest(request, near, rest)
        found = await self._fitting(text, is_alternative=is_alternative)
        if any(takes(request, one) for one in found):
            return found
        # the word may be the name of a part that takes the command: a button called Garage door
        return await self._named_part(text, request) or found

    async def _named_part(self, text: str, taking: CommandDevicesRequest | None = None) -> list[Target]:
        """Return the parts of a device that are called *text*, such as one of four relays; one has to take *taking*."""
        words, name = words_of(text), fold(text)
        devices = await self._lookup.devices(And(tuple(map(HasText, words)))) if words else ()
        named = [
            (one, tuple([part for part in controls(one.parts) if name in _own_names(one, part)])) for one in devices
        ]
        found = [one for one in named if one[1] and (taking is None or takes(taking, one))]
        if len(found) > 1:
            ids = ", ".join(f"{device.id}#{parts[0].id}" for device, parts in found[:10])
            raise NoTargetError(f"{len(found)} devices have a part called {text}; give the id of one: {ids}")
        return found

    async def _nearest(self, request: CommandDevicesRequest, near: IsNear, rest: Query) -> list[Target]:
        """Return the nearest target that may be commanded; if none may, the error names the nearest and the reasons."""
        wanted = query_terms(And((rest, near)))
        answer = await self._query.call(QueryDevicesRequest(query=wanted, limit=_MOST_NEAR))
        if not answer.success:
            raise NoTargetError(answer.message)
        refused = [f"{one.key}: {one.value}" for one in answer.left_out]
        for one in answer.results:
            device = one.device
            if _is_spelled(rest, facets_of(device).words):
                target = device, _parts(device, rest)
                if not (problem := self._refusal(request, target)):
                    return [target]
                refused.append(f"{device.name}: {problem}")
        if refused:
            raise NoTargetError(f"nothing near {near.robot} may be commanded; left out: {'; '.join(refused)}")
        return []

    async def _fitting(self, text: str, *, is_alternative: bool) -> list[Target]:
        query = parse_query(text)
        if _texts(query) and (named := await self._named_part(text)):
            return named
        total = await self._total(query)
        if not total:
            return await self._named_part(text)
        if total > MOST_DEVICES:
            raise NoTargetError(f"{total:,} devices fit {text!r}; at most {MOST_DEVICES:,} may be commanded")
        meant = _numbered(query, _spelled(text, query, await self._lookup.devices(query)))
        found = [(device, _parts(device, query)) for device in meant]
        is_selected = any(isinstance(one, TypeIs | CanDo | StateIs) for one in leaves(query))
        if len(found) > 1 and _texts(query) and not is_selected and not is_alternative:
            raise NoTargetError(f"{text!r} could be {_names(found)}; give the name of one, or a type")
        return found

    async def _total(self, query: Query) -> int:
        answer = await self._query.call(QueryDevicesRequest(query=query_terms(query), limit=1))
        if not answer.success:
            raise NoTargetError(answer.message)
        return answer.total


_JOINED = re.compile(r"\band\b|,", re.IGNORECASE)
_ARTICLE = re.compile(r"(?:the|an?|my)\s+(.+)", re.IGNORECASE | re.DOTALL)
_QUOTED = re.compile(r'"([^"]+)"')
_EVERYTHING = re.compile(r"\s*(?:everything|all)\b", re.IGNORECASE)
_ONE = re.compile(r"an?\s", re.IGNORECASE)
_MOST_NAMES = 8

_MOST_NEAR = 10
"""The number of nearest devices that are tried."""


def _places(targets: list[Target]) -> frozenset[tuple[str, str]]:
    return frozenset((device.id, part.id) for device, parts in targets for part in parts)


def _names(targets: list[Target]) -> str:
    names = sorted(part_name(device, part) for device, parts in targets for part in parts)
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return f"{', '.join(names[:_MOST_NAMES])}{more}" or "nothing"


def _own_names(device: Device, part: DevicePart) -> tuple[str, str]:
    return fold(part.part.name), fold(f"{device.name} {part.part.name}")  # the second as homebot prints it


def _is_spelled(query: Query, words: tuple[str, ...]) -> bool:
    """Return whether a device with these *words* fits *query* without a typo: a search may guess, a command may not."""
    match query:
        case And(terms):
            return all(_is_spelled(term, words) for term in terms)
        case Or(terms):
            return any(_is_spelled(term, words) for term in terms)
        case HasText(word) if word.isdecimal():
            return word in words
        case HasText(word):
            return any(one.startswith(word) for one in words)
        case _:
            return True


def _spelled(text: str, query: Query, devices: tuple[Device, ...]) -> list[Device]:
    """Return the *devices* that fit the query *text* without a typo; if none does, the error names similar ones."""
    meant = [device for device in devices if _is_spelled(query, facets_of(device).words)]
    if devices and not meant:
        similar = " or ".join(device.name or device.id for device in devices[:3])
        raise NoTargetError(f"no device fits {text!r}; did you mean {similar}?")
    return meant


def _numbered(query: Query, devices: list[Device]) -> list[Device]:
    """Return the *devices* with the numbers of *query* in their names, or all: a room may have a number too."""
    numbers = {word for word in _texts(query) if word.isdecimal()}
    return [one for one in devices if numbers <= _called(one)] or devices


def _called(device: Device) -> set[str]:
    """Return the words of the id and the names of *device*."""
    return set(chain.from_iterable(map(words_of, (device.id, device.name, *device.names))))


def _main_parts(device: Device) -> tuple[DevicePart, ...]:
    """Return the main parts that take commands; if there are none, any one part, which refuses the command."""
    if not device.parts:
        raise NoTargetError(f"{device.id} takes no commands that homebot knows")
    return controls(device.parts) or device.parts[:1]


def _parts_called(request: CommandDevicesRequest, device: Device, name: str) -> tuple[DevicePart, ...]:
    """Return the only part of *device* called *name*, as of a bridge that gives each part a device's name; or else all.

    The name of a device and of one part among others that take the command is ambiguous.
    """
    parts = _main_parts(device)
    named = [one for one in parts if fold(one.part.name) == fold(name)]
    if len(named) != 1 or len(parts) == 1 or (request.target == device.id != device.name):
        return parts
    names = set(map(fold, device.names))
    able = [one for one, parsed in settings_by_part(request, device, parts) if not isinstance(parsed, RefusedError)]
    if fold(name) != fold(device.name) or names.issuperset(fold(one.part.name) for one in able):
        return tuple(named)
    if named[0] in able and len(able) > 1:
        ids = ", ".join(f"{device.id}#{one.id}" for one in able[:_MOST_NAMES])
        raise NoTargetError(f"{name!r} could be {_names([(device, tuple(able))])}; give the id of one: {ids}")
    return parts


def _parts(device: Device, query: Query) -> tuple[DevicePart, ...]:
    """Return the main parts that fit the query by themselves, or all if none does.

    A word that occurs in the names of parts, but not in those of the device, selects these parts.
    """
    main = _main_parts(device)
    meant = [part for part in main if fits(query, PartFacets(device, part))] or list(main)
    called = _called(device).union(*map(words_of, (device.area, *device.tags)))
    for word in _texts(query):
        if not any(one.startswith(word) for one in called):
            named = [one for one in meant if any(own.startswith(word) for own in words_of(one.part.name))]
            meant = named or meant
    return tuple(meant)


def _texts(query: Query) -> tuple[str, ...]:
    """Return the words that a device must have."""
    terms = query.terms if isinstance(query, And) else (query,)
    return tuple(one.text for one in terms if isinstance(one, HasText))
