"""Search for the one device that a text of a client means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import TYPE_CHECKING, NamedTuple, Protocol, cast

from homebot.bridges.home_api.shapes import ProblemError
from homebot.devices.device_names import devices_called, name_query
from homebot.devices.names import FIND_DEVICES, LIST_DEVICES
from homebot.devices.query.term_messages import query_terms
from homebot.devices.services import MAX_LISTED
from homebot.devices.wording.json_message import JsonMessage
from homebot.messages.json import message_to_json
from homebot.support.names import close_names
from homebot.words.queries import parse_query

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.services import ListDevicesResponse, ListedDevice

_MAX_PAGES = 10
_MAX_NAMED = 10
_MAX_SIMILAR = 3
_SEVERAL = ("all ", "everything")


class HomeCalls(Protocol):
    """The services of the house, called with the rights of one client."""

    @property
    def home(self) -> str:
        """The name of the home; empty for none."""

    def now(self) -> float:
        """Return the time of the house, in seconds since 1970."""

    def offers(self, service: str) -> bool:
        """Return whether *service* has a server."""

    async def call(self, service: str, request: Mapping[str, object]) -> JsonMessage:
        """Return the answer of *service*.

        Raises:
            ProblemError: The client lacks the right, or there is no answer.
        """


class MeantDevice(NamedTuple):
    """A device that a client means.

    Attributes:
        target: The words by which a command reaches it, or the part that is meant.
    """

    device: Device
    target: str


async def meant_device(home: HomeCalls, text: str) -> MeantDevice:
    """Return the device with the id or name *text*, ``ID#PART`` for one with a part, or the only one that fits it.

    As in a command of ``homebot do``, a word with a typo, or a part of one, fits nothing.

    Raises:
        ProblemError: There is none, with similar ones named, or there are several, all named.
    """
    devices = await _named(home, text.strip())
    if len(devices) == 1:
        ident, hash_sign, part = text.strip().partition("#")
        is_by_id = devices[0].id.casefold() == ident.casefold()
        return MeantDevice(devices[0], f"{devices[0].id}{hash_sign}{part}" if is_by_id else devices[0].id)
    ids = [known.id for known in devices] or await _fitting(home, text)
    if not devices and len(ids) == 1:
        return MeantDevice((await _search(home, {"ids": ids}))[0], text)
    more = ", …" if len(ids) >= _MAX_NAMED else ""
    problem = f"several devices fit {text!r}; give the id of one: {', '.join(ids[:_MAX_NAMED])}{more}"
    raise ProblemError(HTTPStatus.CONFLICT, problem)


async def all_meant(home: HomeCalls, text: str) -> list[str]:
    """Return the ids of at most ten devices of ``all lights in hall`` or ``everything``; empty for other words.

    Raises:
        ProblemError: There is none.
    """
    if not text.casefold().startswith(_SEVERAL) or await _named(home, text.strip()):
        return []
    return await _fitting(home, text)


async def _named(home: HomeCalls, text: str) -> Sequence[Device]:
    """Return the devices with the id, with or without a part, or the name *text*."""
    device_id = text.partition("#")[0]
    terms = query_terms(name_query(text, device_id))
    devices = await _search(home, {"query": [message_to_json(term) for term in terms]})
    return devices_called(text, devices, device_id)


async def _fitting(home: HomeCalls, text: str) -> list[str]:
    answer = await listed(home, query=text, limit=_MAX_NAMED, is_spelled=True)
    if not answer.success:
        raise ProblemError(HTTPStatus.NOT_FOUND, answer.message)
    if answer.devices:
        return [device.id for device in answer.devices]
    near = [device.id for device in (await listed(home, query=text, limit=_MAX_SIMILAR)).devices]
    names = near or [name for device in await all_listed(home) for name in (device.id, device.name)]
    reason = answer.message or "a list of all devices shows what there is"
    hint = f"did you mean {' or '.join(near)}?" if near else close_names(text, names, reason)
    raise ProblemError(HTTPStatus.NOT_FOUND, f"no device fits {text!r}; {hint}")


async def listed(home: HomeCalls, *, query: str = "", **request: object) -> ListDevicesResponse:
    """Return the devices that fit the fields of a :class:`homebot.devices.services.ListDevicesRequest`, in short."""
    parse_query(query)
    request["query"] = query
    return cast("ListDevicesResponse", await home.call(LIST_DEVICES, request))


async def all_listed(home: HomeCalls) -> Sequence[ListedDevice]:
    """Return all devices in short; of a large house the first 2,000."""
    devices: list[ListedDevice] = []
    for _ in range(_MAX_PAGES):
        page = await listed(home, limit=MAX_LISTED, offset=len(devices))
        devices += page.devices
        if len(devices) >= page.total or not page.devices:
            break
    return devices


async def _search(home: HomeCalls, request: Mapping[str, object]) -> list[Device]:
    answer = await home.call(FIND_DEVICES, {**request, "is_checked": False})
    return cast("list[Device]", answer.devices)
