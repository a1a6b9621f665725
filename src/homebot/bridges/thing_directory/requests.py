"""The requests to the directory, and the answers.

=============================  ====================================================================================
``/.well-known/wot``           the description of the directory
``/things``                    the list, in pages: ``offset``, ``limit``, ``sort_order``, ``format``
``/things/ID``                 the description of a thing
``/things/ID/properties``      the values of all its properties
``/things/ID/properties/NAME`` one value; PUT sets it
=============================  ====================================================================================

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, sections 6.2 and 7.3.2.1; "Web of Things
(WoT) Thing Description 1.1", section 8.3.1 (HTTP).
"""

from http import HTTPStatus
from typing import TypeGuard

from homebot.bridges.thing_directory.documents import (
    LD_TYPE,
    TD_TYPE,
    DirectoryAnswer,
    RequestError,
    at_base,
    page_of,
)
from homebot.bridges.thing_directory.http_server import HttpExchange
from homebot.bridges.thing_directory.listed_devices import ListedDevices, ListedProperty
from homebot.conventions.payload import compact_json, parse_json
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.outcomes import Gone, NoAnswer, Outcome, Refused
from homebot.devices.value import PlainValue
from homebot.errors import PeerError, UsageError, WireError

__all__ = ["DirectoryRequests"]

MAX_BODY_BYTES = 64 * 1024

_JSON = "application/json"
_EXPECTED = {"bool": "true or false", "text": "a text in quotes", "number": "a number", "numbers": "a list of numbers"}
_READ = frozenset({"GET", "HEAD"})
_MOST_NUMBERS = 16


class DirectoryRequests:
    """The answers to requests; *version* identifies the catalog of this run."""

    def __init__(self, description: str, devices: ListedDevices, version: str) -> None:
        self._description = description
        self._devices = devices
        self._catalog = devices.catalog
        self._version = version

    async def answer(self, request: HttpExchange) -> DirectoryAnswer:
        """Return the answer to *request*; raise RequestError, which holds one, if it is not carried out."""
        if request.method not in _READ and not await request.read(MAX_BODY_BYTES):
            raise RequestError(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"a body has at most {MAX_BODY_BYTES} bytes")
        match request.path:
            case (".well-known", "wot"):
                _check_method(request, _READ)
                return DirectoryAnswer(at_base(self._description, request.base).encode(), TD_TYPE)
            case ("things",):
                _check_method(request, _READ)
                return self._list(request)
            case ("things", thing):
                return self._retrieve(request, thing)
            case ("things", thing, "properties"):
                _check_method(request, _READ)
                values = {name: _value(one) for name, one in self._properties(thing).items() if one.capability.readable}
                return DirectoryAnswer(compact_json(values).encode(), _JSON)
            case ("things", thing, "properties", name):
                return await self._use(request, thing, name)
            case _:
                raise RequestError(HTTPStatus.NOT_FOUND, f"there is nothing at /{'/'.join(request.path)}")

    def _list(self, request: HttpExchange) -> DirectoryAnswer:
        page = page_of(request.query)
        etag = f'"{self._version}-{self._catalog.version}"'
        headers = {"ETag": etag}
        links = [f'<{page.address(page.offset)}>; rel="canonical"; etag={etag}']
        following = page.offset + page.limit
        has_more = following < len(self._catalog)
        if has_more:
            links.insert(0, f'<{page.address(following)}>; rel="next"')
        headers["Link"] = ", ".join(links)
        if _matches(request, etag):
            return DirectoryAnswer(b"", "", HTTPStatus.NOT_MODIFIED, headers)
        found = self._catalog.page(page.offset, page.limit, is_descending=page.is_descending)
        text = f"[{','.join(at_base(one.text, f'{request.base}/') for one in found)}]"
        if page.is_collection:
            rest = f',"next":{compact_json(page.address(following))}' if has_more else ""
            text = (
                '{"@context":"https://www.w3.org/2022/wot/discovery","@type":"ThingCollection",'
                f'"total":{len(self._catalog)},"@id":{compact_json(page.address(page.offset))},"members":{text}{rest}}}'
            )
        return DirectoryAnswer(text.encode(), LD_TYPE, headers=headers)

    def _retrieve(self, request: HttpExchange, thing: str) -> DirectoryAnswer:
        _check_method(request, _READ)
        listed = self._catalog.get(thing)
        if listed is None:
            raise _no_thing(thing)
        headers = {"ETag": f'"{listed.etag}"'}
        if _matches(request, headers["ETag"]):
            return DirectoryAnswer(b"", "", HTTPStatus.NOT_MODIFIED, headers)
        return DirectoryAnswer(at_base(listed.text, f"{request.base}/").encode(), TD_TYPE, headers=headers)

    async def _use(self, request: HttpExchange, thing: str, name: str) -> DirectoryAnswer:
        one = self._properties(thing).get(name)
        if one is None:
            raise RequestError(HTTPStatus.NOT_FOUND, f"the thing has no property {name}")
        allowed = _READ if one.capability.readable else frozenset()
        _check_method(request, allowed | {"PUT"} if one.is_writable else allowed)
        if request.method != "PUT":
            return DirectoryAnswer(compact_json(_value(one)).encode(), _JSON)
        await _command(one, _plain_value(one, request.body))
        return DirectoryAnswer(status=HTTPStatus.NO_CONTENT)

    def _properties(self, thing: str) -> dict[str, ListedProperty]:
        properties = self._devices.properties(thing)
        if properties is None:
            raise _no_thing(thing)
        return properties


async def _command(one: ListedProperty, value: PlainValue) -> None:
    try:
        outcome = await one.handle.command(one.capability.name, value)
    except (PeerError, UsageError) as exc:
        raise RequestError(HTTPStatus.BAD_REQUEST, str(exc)) from exc
    if not outcome.succeeded:
        raise RequestError(_status_of(outcome), outcome.text)


def _status_of(outcome: Outcome) -> HTTPStatus:
    match outcome:
        case Refused():
            return HTTPStatus.FORBIDDEN
        case NoAnswer(reason=""):
            return HTTPStatus.GATEWAY_TIMEOUT
        case NoAnswer():
            return HTTPStatus.SERVICE_UNAVAILABLE
        case Gone():
            return HTTPStatus.NOT_FOUND
        case _:
            return HTTPStatus.CONFLICT


def _value(one: ListedProperty) -> PlainValue:
    return one.handle.value(one.capability.name)


def _plain_value(one: ListedProperty, body: bytes) -> PlainValue:
    """Return the value that *body* is; raise RequestError if it is none of this property."""
    kind = CAPABILITIES[one.capability.name].kind if one.capability.name in CAPABILITIES else "text"
    expected = f"the value of {one.capability.name} is {_EXPECTED[kind]}"
    try:
        value = parse_json(body, MAX_BODY_BYTES)
    except WireError as exc:
        problem = "the body is not valid JSON" if body.strip() else "the body is empty"
        raise RequestError(HTTPStatus.BAD_REQUEST, f"{problem}; {expected}") from exc
    match kind, value:
        case ("bool", bool() as found) | ("text", str() as found):
            return found
        case "number", _ if _is_number(value):
            return _number(value)
        case "numbers", list() if len(value) <= _MOST_NUMBERS and all(map(_is_number, value)):
            return tuple(map(_number, value))
    raise RequestError(HTTPStatus.BAD_REQUEST, expected)


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _number(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise RequestError(HTTPStatus.BAD_REQUEST, "a number is too large") from None


def _check_method(request: HttpExchange, allowed: frozenset[str]) -> None:
    if request.method not in allowed:
        problem = "this directory is read only" if len(request.path) <= 2 else "the property cannot be used that way"
        raise RequestError(HTTPStatus.METHOD_NOT_ALLOWED, problem, Allow=", ".join(sorted(allowed)))


def _matches(request: HttpExchange, etag: str) -> bool:
    known = ",".join(request.headers("If-None-Match"))
    return known.strip() == "*" or etag in {one.strip().removeprefix("W/") for one in known.split(",")}


def _no_thing(thing: str) -> RequestError:
    return RequestError(HTTPStatus.NOT_FOUND, f"the directory lists no {thing[:100]}")
