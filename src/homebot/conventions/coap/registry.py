"""The registrations of a resource directory, and its answers to lookups. Pure, and bounded.

Source: RFC 9176, sections 5 and 6. Lookups are filtered by the parameters and attributes that the RFC has.
"""

import itertools
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from homebot.conventions.coap.endpoint import CoapEndpoint, endpoint_of_link, host_of
from homebot.conventions.coap.link_format import WebLink
from homebot.conventions.payload import shown
from homebot.errors import RefusedError, WireError
from homebot.support.addresses import is_loopback, parse_address, resolve_uri

__all__ = ["FORBIDDEN", "DirectoryRegistry", "EndpointRegistration"]

FORBIDDEN = 0x83
"""The code of the error if a registration is another host's: that of the response 4.03."""

MAX_REGISTRATIONS = 1000
MAX_PER_HOST = 64
"""Registrations that come from one address: a gateway registers for its devices, a flood comes from few places."""

MAX_LINKS_OF_ONE = 100
_DEFAULT_LIFETIME = 90_000
_LONGEST_LIFETIME = 2**32 - 1
_MAX_TEXT = 200


@dataclass(frozen=True, slots=True)
class EndpointRegistration:
    """A registration.

    Attributes:
        path: Where it can be renewed and deleted: ``/rd/1``.
        parameters: The parameters of its endpoint: ``ep``, ``d``, ``base``, ``lt``, ``et``.
        expires_at: Reading of the monotonic clock at which it ends.
    """

    path: str
    parameters: Mapping[str, str]
    links: tuple[WebLink, ...]
    source: str
    expires_at: float

    @property
    def link(self) -> WebLink:
        """The link that a lookup of endpoints has for it."""
        return WebLink(self.path, (*self.parameters.items(), ("rt", "core.rd-ep")))

    @property
    def endpoint(self) -> CoapEndpoint:
        """The endpoint that it is about."""
        return replace(endpoint_of_link(self.link), source=self.path)


class DirectoryRegistry:
    """All registrations of a directory.

    Attributes:
        refused: Registrations that were refused because there were too many.
    """

    def __init__(self) -> None:
        self.refused = 0
        self._by_path: dict[str, EndpointRegistration] = {}
        self._paths: dict[tuple[str, str], str] = {}
        self._numbers = itertools.count(1)
        self._of_source: Counter[str] = Counter()

    def register(
        self, parameters: Mapping[str, str], links: tuple[WebLink, ...], source: str, base: str, now: float
    ) -> EndpointRegistration:
        """Take a registration; one of the same endpoint takes the place of the one before, if it is of the same host.

        A name belongs to its first registrant until that registration ends (RFC 9176, section 7.5).

        Args:
            source: The host that it came from.
            base: The address that it came from, which counts unless it names one.
            now: Reading of the monotonic clock.

        Raises:
            WireError: It breaks the rules; says which.
            RefusedError: There are too many, it is for the address of another host, or that has one of that name.
        """
        checked = self.check({"base": base, **parameters})
        _check_source(checked, source)
        if len(links) > MAX_LINKS_OF_ONE:
            raise WireError(f"{len(links)} links are too many for one endpoint; the limit is {MAX_LINKS_OF_ONE}")
        _check_targets(checked["base"], links)
        name = checked["ep"], checked.get("d", "")
        path = self._paths.get(name)
        if path is None:
            if len(self._by_path) >= MAX_REGISTRATIONS or self._of_source[source] >= MAX_PER_HOST:
                self.refused += 1
                raise RefusedError(f"the registration of {shown(name[0])}", "there are too many")
            path = f"/rd/{next(self._numbers)}"
        else:
            self.remove(path, source)
        made = EndpointRegistration(path, checked, links, source, now + float(checked["lt"]))
        self._by_path[path] = made
        self._paths[name] = path
        self._of_source[source] += 1
        return made

    def check(self, parameters: Mapping[str, str]) -> dict[str, str]:
        """Return the query parameters of a registration, completed with defaults.

        Raises:
            WireError: They break the rules; says which.
        """
        checked = _checked(parameters)
        endpoint_of_link(WebLink("", tuple(checked.items())))
        return checked

    def renew(self, path: str, parameters: Mapping[str, str], source: str, now: float) -> EndpointRegistration:
        """Update a registration, with a new lifetime; parameters that it leaves out stay unchanged.

        Raises:
            WireError: It breaks the rules: neither name nor sector can be changed.
            RefusedError: It is that of another host than *source*, or is to be.
            KeyError: There is none.
        """
        before = self._of(path, source)
        if not {"ep", "d"}.isdisjoint(parameters):
            raise WireError("ep and d cannot be changed")
        checked = self.check({**before.parameters, **parameters})
        _check_source(checked, source)
        renewed = replace(before, parameters=checked, expires_at=now + float(checked["lt"]))
        self._by_path[path] = renewed
        return renewed

    def remove(self, path: str, source: str) -> EndpointRegistration:
        """Remove a registration.

        Raises:
            RefusedError: It is that of another host than *source*.
            KeyError: There is none.
        """
        gone = self._of(path, source)
        del self._by_path[path]
        del self._paths[gone.parameters["ep"], gone.parameters.get("d", "")]
        self._of_source[gone.source] -= 1
        if not self._of_source[gone.source]:
            del self._of_source[gone.source]
        return gone

    def expire(self, now: float) -> tuple[EndpointRegistration, ...]:
        """Remove and return the registrations that have ended."""
        ended = [one for one in self._by_path.values() if one.expires_at <= now]
        return tuple(self.remove(one.path, one.source) for one in ended)

    def look_up_endpoints(self, query: Mapping[str, str]) -> tuple[WebLink, ...]:
        """Return a link for each endpoint that fits *query*, or has a resource that does."""
        found = (
            one.link
            for one in self._by_path.values()
            if all(
                _fits(one.link, name, text) or any(_fits(link, name, text) for link in one.links)
                for name, text in _conditions(query)
            )
        )
        return _page(found, query)

    def look_up_resources(self, query: Mapping[str, str]) -> tuple[WebLink, ...]:
        """Return the resources that fit *query*, or are of an endpoint that does, with absolute addresses."""
        found = (
            WebLink(resolve_uri(f"{one.parameters['base']}/", link.target), link.attributes)
            for one in self._by_path.values()
            for link in one.links
            if all(_fits(link, name, text) or _fits(one.link, name, text) for name, text in _conditions(query))
        )
        return _page(found, query)

    def _of(self, path: str, source: str) -> EndpointRegistration:
        found = self._by_path[path]
        if found.source != source:
            registration = f"the registration of {shown(found.parameters['ep'])}"
            raise RefusedError(registration, "it is another host's", FORBIDDEN)
        return found


def _check_source(parameters: Mapping[str, str], source: str) -> None:
    """Check that a registration is for the host that it comes from.

    Only a program on this computer may register other hosts: it is a commissioning tool of RFC 9176, section 5.

    Raises:
        RefusedError: It is for another host.
    """
    base = host_of(parameters["base"])
    address, zone = parse_address(base), base.partition("%")[2]
    is_own = address is not None and address == parse_address(source) and zone in {"", source.partition("%")[2]}
    if not is_own and not is_loopback(source):
        problem = f"a registration speaks for its own address {source}, not for {shown(parameters['base'])}"
        raise RefusedError(f"the registration of {shown(parameters['ep'])}", problem, FORBIDDEN)


def _check_targets(base: str, links: tuple[WebLink, ...]) -> None:
    for link in links:
        try:
            resolve_uri(f"{base}/", link.target)
        except ValueError:
            raise WireError(f"the link {link.target[:60]!a} is not an address") from None


def _checked(parameters: Mapping[str, str]) -> dict[str, str]:
    for name, text in parameters.items():
        if len(name) > _MAX_TEXT or len(text) > _MAX_TEXT or not (name + text).isprintable() or '"' in name:
            raise WireError(f"the parameter {shown(name)} is too long, or has control characters")
    if len(parameters) > 20:
        raise WireError("a registration has more than 20 parameters")
    if not parameters.get("ep"):
        raise WireError("ep is missing")
    return {**parameters, "lt": _checked_lifetime(parameters.get("lt") or str(_DEFAULT_LIFETIME))}


def _checked_lifetime(seconds: str) -> str:
    if not (seconds.isascii() and seconds.isdecimal() and 1 <= int(seconds[:11]) <= _LONGEST_LIFETIME):
        raise WireError(f"lt {shown(seconds)} is not a number from 1 to {_LONGEST_LIFETIME}")
    return seconds


def _conditions(query: Mapping[str, str]) -> list[tuple[str, str]]:
    return [(name, text) for name, text in query.items() if name not in {"page", "count"}]


def _fits(link: WebLink, name: str, text: str) -> bool:
    given = (link.target,) if name == "href" else link.words(name) if name in {"rt", "if"} else (link.get(name),)
    if text.endswith("*"):
        return any(one.startswith(text[:-1]) for one in given if one or name == "href")
    return text in given and (bool(text) or link.has(name))


def _page(links: Iterable[WebLink], query: Mapping[str, str]) -> tuple[WebLink, ...]:
    """Return one page of *links*, by ``page`` and ``count``.

    Raises:
        WireError: They are no numbers.
    """
    page, count = query.get("page", "0"), query.get("count", str(MAX_REGISTRATIONS * MAX_LINKS_OF_ONE))
    if not (page.isdecimal() and count.isdecimal() and len(page) < 7 and len(count) < 7):
        raise WireError("page and count are whole numbers")
    first = int(page) * int(count)
    return tuple(itertools.islice(links, first, first + int(count)))
