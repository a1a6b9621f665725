"""The endpoints of a device, one for each gateway that knows it, and its reachability. Pure."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import chain
from operator import attrgetter
from typing import TypeAlias

from homebot.devices import DevicePart, Endpoint, Freshness, Reachability, Route
from homebot.devices.names import text_address
from homebot.devices.text.commands import accepts_text
from homebot.discovery.source_record import Reach, SourceKey, SourceRecord
from homebot.discovery.topics.use import place_of
from homebot.messages import Time

_SourceReach: TypeAlias = tuple[SourceRecord, str, Reach | None]
"""The reachability of a part according to one announcement."""

NOT_REPORTED = Reachability()
"""The reachability of a device without such reports."""


def reachability(sources: Iterable[SourceRecord]) -> Reachability:
    """Return whether a device can be reached: the combined reachability of its parts.

    One reachable part is enough. If some are unreachable, none is reachable, and others of unknown reachability have
    reported since, it is unknown. Gateways without a link know nothing; if all lack one, the device is unreachable.
    """
    known = tuple(sources)
    linked = [source for source in known if not source.is_lost]
    lost = [source.lost for source in known if source.lost is not None]
    if lost and not linked:
        newest = max(lost, key=lambda loss: loss.since.to_seconds())
        return Reachability(state="no", since=newest.since, why=newest.why)
    reports: list[_SourceReach] = []
    for source in linked:
        if len(source.reach) == 1 and "" in source.reach:
            reports.append((source, "", source.reach[""]))
        elif not source.reach:
            reports.append((source, "", None))
        else:
            reports += [(source, part.id, source.reach_of(part.id)) for part in source.sighting.parts]
    return _combine(reports)


def offline_parts(
    sources: Mapping[SourceKey, SourceRecord], places: Mapping[tuple[str, str, str], int], ids: Mapping[int, str]
) -> tuple[str, ...]:
    """Return the ids of the parts that cannot be reached, by the rule of :func:`reachability`."""
    reports: dict[int, list[_SourceReach]] = {}
    for (gateway, key, part), place in places.items():
        source = sources.get((gateway, key))
        if source is not None:
            linked = reports.setdefault(place, [])
            if not source.is_lost:
                linked.append((source, part, source.reach_of(part)))
    return tuple(
        ids[place] for place in sorted(reports) if not reports[place] or _combine(reports[place]).state == "no"
    )


def _combine(reports: list[_SourceReach]) -> Reachability:
    """Return the newest of *reports* that say yes; else of those that say no; else of those that do not know."""
    for value in (True, False, None):
        answers = [
            (source, part, report) for source, part, report in reports if report is not None and report.value is value
        ]
        if answers:
            source, part, reach = max(answers, key=lambda answer: answer[2].heard_at)
            label = source.label if source.sighting.convention else "it"  # the key of a gateway means nothing to people
            is_all_of_it = all(
                report is not None and report.value is value for other, _, report in reports if other is source
            )
            label = label if is_all_of_it or part in label else f"{label} ({part})"
            if reach.value is None:
                why = f"{label} was reported offline, but it sends messages"
                return Reachability(state="unknown", since=reach.since, why=why)
            if reach.value:
                return Reachability(
                    state="yes", since=reach.since, why=f"{label} is online, {_according(source, reach)}"
                )
            later = _reported_later(reports, reach.heard_at)
            if later is None:
                return Reachability(
                    state="no", since=reach.since, why=f"{label} is offline, {_according(source, reach)}"
                )
            why = f"{label} is offline, but {later.label} reported since"
            return Reachability(state="unknown", since=later.seen_at, why=why)
    return NOT_REPORTED


def _according(source: SourceRecord, reach: Reach) -> str:
    reporter = reach.address if source.sighting.convention else source.key[0]
    return f"according to {reporter}" + ("" if reach.live else ", in a retained message")


def _reported_later(reports: list[_SourceReach], since: float) -> SourceRecord | None:
    """Return an announcement of unknown or doubtful reachability by which the device reported after *since*."""
    undecided = (source for source, _, report in reports if report is None or report.value is None)
    return next((source for source in undecided if source.confirmed and source.heard_at > since), None)


_KEY = attrgetter("key")

Addresses: TypeAlias = tuple[SourceKey, str, str]
"""The decisive announcement at one gateway, and the device's addresses there: for its texts and for commands."""


def addresses(sources: Sequence[SourceRecord], main: DevicePart | None) -> tuple[Addresses, ...]:
    """Return the addresses at each gateway, once: two conventions at one gateway publish everything twice.

    Args:
        sources: The announcements, preferred ones first.
        main: The main part of the device; None if its parts are unknown.
    """
    by_gateway: dict[str, Addresses] = {}
    if main is not None:
        known = dict(zip(map(_KEY, sources), sources, strict=True))
        accepts = accepts_text(main.part)
        for route in main.routes:
            if route.gateway in by_gateway:
                continue
            sighting = known[route.gateway, route.key].sighting
            if sighting.is_plain_text:
                address, command_address = sighting.address, sighting.command_address
            else:
                address = text_address(route.key, route.part)
                command_address = address if accepts and route.takes else _command_address(main, route.gateway)
            by_gateway[route.gateway] = (route.gateway, route.key), address, command_address
    for source in sources:
        sighting = source.sighting
        if sighting.gateway not in by_gateway:
            command_address = "" if main is not None or source.is_claimed else sighting.command_address
            by_gateway[sighting.gateway] = source.key, sighting.address, command_address
    return tuple(by_gateway.values())


def endpoints(
    described: Iterable[Addresses],
    sources: Mapping[SourceKey, SourceRecord],
    freshness: Freshness,
    stale_gateways: frozenset[str],
) -> tuple[Endpoint, ...]:
    """Return the current endpoints; those that are offline, stale or only claimed come last."""
    entries: list[Endpoint] = []
    for (gateway, key), address, command_address in described:
        heard = [source for source in sources.values() if source.key[0] == gateway]
        entries.append(
            Endpoint(
                gateway=gateway,
                key=key,
                address=address,
                command_address=command_address,
                freshness=_freshness(heard, freshness, is_stale=gateway in stale_gateways),
                last_seen=last_seen(heard),
                reachable=reachability(heard).state,
                claimed=all(source.is_claimed for source in heard),
            )
        )
    if len(entries) > 1:
        entries.sort(key=lambda endpoint: (endpoint.claimed, endpoint.reachable == "no", endpoint.freshness == "stale"))
    return tuple(entries)


def endpoint_reach(sources: Mapping[SourceKey, SourceRecord]) -> tuple[str, ...]:
    """Return for each gateway whether the device can be reached there."""
    gateways = dict.fromkeys(gateway for gateway, _ in sources)
    return tuple(
        reachability([source for source in sources.values() if source.key[0] == gateway]).state for gateway in gateways
    )


def rank_in(prefer: Sequence[str], gateway: str) -> int:
    """Return the rank of *gateway* in *prefer*, from 0; gateways not listed come last."""
    return prefer.index(gateway) if gateway in prefer else len(prefer)


def preferred_routes(parts: tuple[DevicePart, ...], prefer: Sequence[str]) -> tuple[DevicePart, ...]:
    """Return *parts* with their routes in the order of *prefer*; those of other gateways last."""
    return _with_sorted_routes(parts, lambda route: rank_in(prefer, route.gateway))


def sorted_routes(
    parts: tuple[DevicePart, ...], sources: Mapping[SourceKey, SourceRecord], stale_gateways: frozenset[str]
) -> tuple[DevicePart, ...]:
    """Return *parts* with unreachable and stale routes last."""

    def order(route: Route) -> tuple[bool, bool]:
        source = sources[route.gateway, route.key]
        reach = source.reach_of(route.part)
        is_away = source.is_lost or (reach is not None and reach.value is False)
        return is_away, route.gateway in stale_gateways

    return _with_sorted_routes(parts, order)


def silent_strangers(sources: Mapping[SourceKey, SourceRecord], denied: Collection[SourceKey]) -> dict[SourceKey, str]:
    """Return the announcements that get no commands before their first report, with the reasons in words.

    Others of their gateway have reported, and their topics share no name with those of these: they may be anybody's.
    Of those that take commands where the heard ones do, only the state topics count; so of *denied* ones, which may not
    use a topic of their commands as others have it, and the reason is empty.
    """
    silent = [
        source
        for source in sources.values()
        if not source.values and any(p.reads and p.writes for p in source.sighting.parts)
    ]
    if not silent or not (heard := [source for source in sources.values() if source.values]):
        return {}
    known, gateways = frozenset(chain.from_iterable(map(_names, heard))), {source.key[0] for source in heard}
    taken = frozenset(chain.from_iterable(part.writes for source in heard for part in source.sighting.parts))
    why = "has other topics than the device, and gets no commands before its first report"
    strangers: dict[SourceKey, str] = {}
    for source in silent:
        is_denied = source.key in denied
        is_reading = is_denied or any(not taken.isdisjoint(part.writes) for part in source.sighting.parts)
        if source.key[0] in gateways and known.isdisjoint(_names(source, is_reading=is_reading)):
            strangers[source.key] = "" if is_denied else f"{source.label} {why}"
    return strangers


def routes_without(parts: tuple[DevicePart, ...], strangers: Collection[SourceKey]) -> tuple[DevicePart, ...]:
    """Return *parts* without the routes of *strangers*."""
    left = [tuple(route for route in part.routes if (route.gateway, route.key) not in strangers) for part in parts]
    return tuple(part.model_copy(update={"routes": routes}) for part, routes in zip(parts, left, strict=True))


def _names(source: SourceRecord, *, is_reading: bool = False) -> frozenset[str]:
    """Return the names in the topics of an announcement, or in those of its states only."""
    parts = source.sighting.parts
    places = [
        place_of(topic) for part in parts for topic in (part.reads if is_reading else (*part.reads, *part.writes))
    ]
    return frozenset(chain.from_iterable(place.levels | place.words for place in places))


def last_seen(sources: Collection[SourceRecord]) -> Time:
    """Return when a device was last seen in *sources*: when it last reported, or else was announced."""
    confirmed = [source for source in sources if source.confirmed]
    return max(confirmed or sources, key=lambda one: (one.heard_at, one.seen_at.sec, one.seen_at.nanosec)).seen_at


def _with_sorted_routes(
    parts: tuple[DevicePart, ...], order: Callable[[Route], int | tuple[bool, bool]]
) -> tuple[DevicePart, ...]:
    sorted_parts = []
    for part in parts:
        routes = tuple(sorted(part.routes, key=order)) if len(part.routes) > 1 else part.routes
        is_same = routes == part.routes
        sorted_parts.append(part if is_same else part.model_copy(update={"routes": routes}))
    return tuple(sorted_parts)


def _freshness(sources: Iterable[SourceRecord], device: Freshness, *, is_stale: bool) -> Freshness:
    if is_stale or device == "stale":
        return "stale"
    return "fresh" if device == "fresh" and any(source.confirmed for source in sources) else "unconfirmed"


def _command_address(part: DevicePart, gateway: str) -> str:
    """Return the address where *part* accepts text: that of the first route of the gateway with one."""
    ways = (
        (route for route in part.routes if route.gateway == gateway and route.takes) if accepts_text(part.part) else ()
    )
    return next((text_address(way.key, way.part) for way in ways), "")
