"""The service ``/devices/command``: commands in words, by id, name or query."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from itertools import chain
from typing import Final, TypeAlias, final

import anyio

from homebot.control.spoken_settings import spoken_settings
from homebot.devices import FIND_DEVICES, QUERY_DEVICES, Device, DevicePart, FindDevices, QueryDevices
from homebot.devices.command_messages import (
    CommandDevicesRequest,
    CommandDevicesResponse,
    CommandedPart,
    CommandRequest,
    CommandResult,
    Setting,
)
from homebot.devices.command_results import outcome_of, result_of
from homebot.devices.outcomes import Refused, worst
from homebot.devices.query import And, HasText, NameIs, Or, PartFacets, Query, fits, parse_query, query_terms
from homebot.devices.query.facets import facets_of
from homebot.devices.query.terms import FactIs
from homebot.devices.services import FindDevicesRequest, QueryDevicesRequest
from homebot.devices.value import PlainValue, Value
from homebot.errors import RefusedError, ServiceError, UsageError
from homebot.folding import fold, words_of
from homebot.graph import Node

__all__ = ["MOST_DEVICES", "CommandService", "Perform"]

MOST_DEVICES: Final = 1000
"""Devices that one command may be for."""

UNNAMED_CLIENT: Final = "client"
"""The issuer of a command that names none."""

Perform: TypeAlias = Callable[[CommandRequest], Awaitable[CommandResult]]
"""Carries out the command to one part."""

_Target: TypeAlias = tuple[Device, tuple[DevicePart, ...]]
_Spoken: TypeAlias = dict[str, PlainValue] | RefusedError
"""The values by capability that a part is to have, or why it cannot have them."""


class _NoTargetError(Exception):
    """Nothing is commanded; the text says why."""


@final
class CommandService:
    """Finds the devices that a command in words is for, and commands all of them at once.

    Args:
        node: The node whose clients ask the directory.
        perform: Carries out each command.
    """

    def __init__(self, node: Node, perform: Perform) -> None:
        self._perform = perform
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._query = node.create_client(QueryDevices, QUERY_DEVICES)

    async def serve(self, request: CommandDevicesRequest) -> CommandDevicesResponse:
        """Carry out *request*; never raises."""
        try:
            targets = await self._targets(request, request.target.strip())
        except (_NoTargetError, ServiceError, UsageError) as exc:
            return CommandDevicesResponse(success=False, message=str(exc))
        commanded: list[CommandedPart] = []
        async with anyio.create_task_group() as tasks:
            for device, parts in targets:
                for part, spoken in _spoken(request, device, parts):
                    tasks.start_soon(self._command, request, device, part, spoken, commanded)
        commanded.sort(key=lambda one: (one.device, one.part))
        outcomes = tuple(outcome_of(one.result) for one in commanded)
        worst_one = commanded[outcomes.index(worst(outcomes))]
        is_done = all(one.succeeded for one in outcomes)
        return CommandDevicesResponse(
            success=is_done,
            message="" if is_done else f"{worst_one.name}: {worst_one.result.text}",
            outcome=worst_one.result.outcome,
            results=tuple(commanded),
        )

    async def _command(
        self,
        request: CommandDevicesRequest,
        device: Device,
        part: DevicePart,
        spoken: _Spoken,
        commanded: list[CommandedPart],
    ) -> None:
        if isinstance(spoken, RefusedError):
            result = result_of(Refused("device", f"{spoken.what}: {spoken.reason}"))
        else:
            result = await self._perform(
                CommandRequest(
                    device=device.id,
                    part=part.id,
                    settings=tuple(Setting(capability=name, value=Value.of(value)) for name, value in spoken.items()),
                    transition=request.transition,
                    code=request.code,
                    issuer=request.issuer or UNNAMED_CLIENT,
                    scope=request.scope,
                    cause=request.cause,
                )
            )
            if result.outcome == "no_answer" and (why_away := await self._why_away(device)):
                result = result.with_checked(text=f"{result.text}; {why_away}")
        commanded.append(CommandedPart(device=device.id, name=_name(device, part), part=part.id, result=result))

    async def _why_away(self, device: Device) -> str:
        """Return why *device* is known to be away now, whatever was known when it was commanded; empty if it is not."""
        try:
            found = await self._devices(FactIs("id", device.id.casefold()))
        except ServiceError:
            found = (device,)
        return next((one.reachable.why for one in found if one.id == device.id and one.reachable.state == "no"), "")

    async def _targets(self, request: CommandDevicesRequest, target: str) -> list[_Target]:
        """Return the parts that are meant, those of each device together.

        Raises:
            _NoTargetError: None are, or too many, or a name that several devices have.
            UsageError: It is no query.
            ServiceError: The directory does not answer.
        """
        if not target:
            raise _NoTargetError("give the id or the name of a device, or a query such as 'light in hall'")
        device_id, _, part_id = target.partition("#")
        named = await self._devices(Or((FactIs("id", device_id.casefold()), NameIs(fold(target)))))
        own = [one for one in named if one.id == device_id]
        if part_id and own:
            return [(own[0], _part(own[0], part_id))]
        called = own or named
        if len(called) > 1:
            ids = ", ".join(one.id for one in called[:10])
            raise _NoTargetError(f"{len(called)} devices are called {target}; give the id of one: {ids}")
        if called:
            return [(called[0], _main_parts(called[0]))]
        found = await self._fitting(target)
        if any(_takes(request, one) for one in found):
            return found
        # what a type means cannot do it, and a part that has the word for a name may: a button called Garage door
        return await self._named_part(target, request) or found

    async def _named_part(self, text: str, taking: CommandDevicesRequest | None = None) -> list[_Target]:
        """Return the parts of a device that are called *text*, such as one of four relays.

        Args:
            text: Their name.
            taking: What they must take; None for anything.

        Raises:
            _NoTargetError: Several devices have such parts.
            ServiceError: The directory does not answer.
        """
        words, name = words_of(text), fold(text)
        devices = await self._devices(And(tuple(map(HasText, words)))) if words else ()
        named = [(one, tuple(part for part in _controls(one.parts) if fold(part.part.name) == name)) for one in devices]
        found = [one for one in named if one[1] and (taking is None or _takes(taking, one))]
        if len(found) > 1:
            ids = ", ".join(f"{device.id}#{parts[0].id}" for device, parts in found[:10])
            raise _NoTargetError(f"{len(found)} devices have a part called {text}; give the id of one: {ids}")
        return found

    async def _fitting(self, text: str) -> list[_Target]:
        query = parse_query(text)
        if _texts(query) and (named := await self._named_part(text)):
            return named
        answer = await self._query.call(QueryDevicesRequest(query=query_terms(query), limit=1))
        if not answer.success:
            raise _NoTargetError(answer.message)
        if not answer.total and (named := await self._named_part(text)):
            return named
        if not answer.total:
            raise _NoTargetError(f"no device fits {text!r}; `homebot find` shows what does")
        if answer.total > MOST_DEVICES:
            raise _NoTargetError(f"{answer.total:,} devices fit {text!r}; at most {MOST_DEVICES:,} may be commanded")
        devices = await self._devices(query)
        meant = [device for device in devices if _is_spelled(query, facets_of(device).words)]
        if devices and not meant:
            similar = " or ".join(device.name or device.id for device in devices[:3])
            raise _NoTargetError(f"no device fits {text!r}; did you mean {similar}?")
        if isinstance(query, HasText) and len(meant) > 1:
            raise _NoTargetError(f"{len(meant)} devices mention {text!r}; give the name of one, or a type")
        return [(device, _parts(device, query)) for device in meant]

    async def _devices(self, query: Query) -> tuple[Device, ...]:
        return (await self._find.call(FindDevicesRequest(query=query_terms(query)))).devices


_APPLIANCES = frozenset(
    {"fan", "robotic_vacuum_cleaner", "room_air_conditioner", "thermostat", "water_heater"}
    | {"x_alarm_panel", "x_humidifier", "x_lawn_mower"}
)
_FUNCTIONS = frozenset({"plug", "switch"})
"""Types of the parts of an appliance that turn one of its functions on and off: its display, its powerful mode."""
_SETTINGS = frozenset({"x_setting"})


def _spoken(
    request: CommandDevicesRequest, device: Device, parts: tuple[DevicePart, ...]
) -> list[tuple[DevicePart, _Spoken]]:
    """Return what *request* sets at each of *parts*, or why it cannot.

    Parts that cannot are left out where one of another type can: a speed is for the fan, and not for its lamp. So are
    the switches of an appliance that can: to turn an air conditioner on is not to turn on its powerful mode. A setting
    that can, as a free text can be ``off``, is left out where any other part can.
    """
    found: list[tuple[DevicePart, _Spoken]] = []
    for part in parts:
        try:
            found.append((part, spoken_settings(request.command, request.values, part.part, _name(device, part))))
        except RefusedError as exc:
            found.append((part, exc))
    able = {part.part.service_type for part, spoken in found if not isinstance(spoken, RefusedError)}
    if not able.isdisjoint(_APPLIANCES):
        able -= _FUNCTIONS
    able = able - _SETTINGS or able
    return [one for one in found if not able or one[0].part.service_type in able]


def _takes(request: CommandDevicesRequest, target: _Target) -> bool:
    return any(not isinstance(spoken, RefusedError) for _, spoken in _spoken(request, *target))


def _name(device: Device, part: DevicePart) -> str:
    """Return what people call *part*: with its id where it has no name, and is one of several that take commands."""
    if part.part.name:
        return f"{device.name} {part.part.name}" if len(device.parts) > 1 else device.name
    return f"{device.name} #{part.id}" if len(_controls(device.parts)) > 1 else device.name


def _is_spelled(query: Query, words: tuple[str, ...]) -> bool:
    """Return whether a device with these *words* fits *query* without a typo: a search may guess, a command may not."""
    match query:
        case And(terms):
            return all(_is_spelled(term, words) for term in terms)
        case Or(terms):
            return any(_is_spelled(term, words) for term in terms)
        case HasText(word):
            return any(one.startswith(word) for one in words)
        case _:
            return True


def _part(device: Device, part_id: str) -> tuple[DevicePart, ...]:
    if (part := device.part(part_id)) is not None:
        return (part,)
    known = ", ".join(one.id for one in device.parts if one.id) or "one part without an id"
    raise _NoTargetError(f"{device.id} has no part {part_id}; it has {known}")


def _main_parts(device: Device) -> tuple[DevicePart, ...]:
    """Return the parts that the device is there for and that take commands; else one, which refuses."""
    if not device.parts:
        raise _NoTargetError(f"{device.id} takes no commands that homebot knows")
    return _controls(device.parts) or device.parts[:1]


def _parts(device: Device, query: Query) -> tuple[DevicePart, ...]:
    """Return those of its main parts that fit the query by themselves, where any does.

    A word that is in the names of parts, and not in what the device is called, means these.
    """
    main = _main_parts(device)
    facets = PartFacets(device)
    found: list[DevicePart] = []
    for part in main:
        facets.part = part
        if fits(query, facets):
            found.append(part)
    meant = found or list(main)
    called = set(chain.from_iterable(map(words_of, (device.id, device.name, *device.names, device.area, *device.tags))))
    for word in _texts(query):
        if not any(one.startswith(word) for one in called):
            named = [one for one in meant if any(own.startswith(word) for own in words_of(one.part.name))]
            meant = named or meant
    return tuple(meant)


def _texts(query: Query) -> tuple[str, ...]:
    """Return the words that a device must have."""
    terms = query.terms if isinstance(query, And) else (query,)
    return tuple(one.text for one in terms if isinstance(one, HasText))


def _controls(parts: Iterable[DevicePart]) -> tuple[DevicePart, ...]:
    return tuple(one for one in parts if not one.part.category and any(can.settable for can in one.part.capabilities))
