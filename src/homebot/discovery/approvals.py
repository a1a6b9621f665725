"""Approvals of announced parts, each bound to the announced description of its commands. Pure."""

from collections.abc import Callable, Collection, Container, Iterable, Iterator
from itertools import islice
from typing import NamedTuple, final

from homebot.devices.part import CommandDescription, payload_digest
from homebot.discovery.merging.part_ids import PartPlace
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.errors import RefusedError

MAX_APPROVALS = 10_000
"""Most approved parts; further ones are refused."""


_MERGED = "it is one device now with others, which were approved separately"


class Approval(NamedTuple):
    """An approval of one announced part.

    Attributes:
        said_at: The time of the approval, in seconds since the Unix epoch.
    """

    description: CommandDescription
    said_at: float


@final
class ApprovalRegistry:
    """The approvals by gateway, key and part; they never belong to a device id or an identifier.

    Attributes:
        on_change: Called after each change.
    """

    def __init__(self) -> None:
        self.on_change: Callable[[], object] = lambda: None
        self._by_place: dict[PartPlace, Approval] = {}

    def __len__(self) -> int:
        return len(self._by_place)

    def put(self, sources: Collection[SourceRecord], now: float, present: Container[SourceKey]) -> tuple[str, ...]:
        """Approve all parts of *sources* that take commands, as :meth:`discard` withdraws earlier approvals.

        Returns:
            The differences from these.
        """
        descriptions = dict(_descriptions(sources))
        if len(self._by_place.keys() | descriptions.keys()) > MAX_APPROVALS:
            raise RefusedError("an approval", f"there are {MAX_APPROVALS:,} already; take some back")
        changes = [(place[1], change) for place, _, change in self.of(sources) if change]
        self.discard(sources, present)
        self._by_place.update({place: Approval(description, now) for place, description in descriptions.items()})
        self.on_change()
        return tuple([f"{key}: {change}" for key, change in changes])

    def discard(self, sources: Iterable[SourceRecord], present: Container[SourceKey]) -> bool:
        """Withdraw the approvals of all announcements *sources*; return whether there were any.

        Args:
            present: All current announcements; those approved together with *sources* that are gone lose theirs too.
        """
        keys, known = {source.key for source in sources}, self._by_place
        times = {approval.said_at for place, approval in known.items() if place[:2] in keys}
        together = [place for place, approval in known.items() if approval.said_at in times]
        places = [place for place in together if place[:2] in keys or place[:2] not in present]
        for place in places:
            del self._by_place[place]
        self.on_change()
        return bool(places)

    @property
    def digests(self) -> tuple[str, ...]:
        """The digests of all approved descriptions."""
        return tuple({approval.description.digest for approval in self._by_place.values()})

    def of(self, sources: Iterable[SourceRecord]) -> Iterator[tuple[PartPlace, Approval, str]]:
        """Yield each approved part of *sources*, its approval, and the changes since then in words, empty for none."""
        for source in sources if self._by_place else ():
            for part in source.sighting.parts:
                place = (*source.key, part.id)
                if (approval := self._by_place.get(place)) is not None:
                    description = CommandDescription.of(part, source.sighting.identifiers)
                    yield place, approval, description.changes(approval.description)

    def of_device(self, sources: Collection[SourceRecord]) -> tuple[tuple[PartPlace, Approval, str], ...]:
        """Return the approvals of a device, as :meth:`of`; they count only if all were given at once.

        Others are of devices that became one since: a right to one of them is none to the others.
        """
        approved = tuple(self.of([source for source in sources if not source.is_claimed]))
        if len({approval.said_at for _, approval, change in approved if not change}) < 2:
            return approved
        return tuple((place, approval, change or _MERGED) for place, approval, change in approved)

    def filter_approved(self, sources: Collection[SourceRecord]) -> tuple[SourceRecord, ...]:
        """Return those of *sources* with an approved part, also if it changed since: others only joined these."""
        known = self._by_place
        return tuple(
            source
            for source in sources
            if known and any((*source.key, part.id) in known for part in source.sighting.parts)
        )

    def records(self) -> Iterator[tuple[str, str, str, CommandDescription, float]]:
        """Yield gateway, key, part, description and time of each, for the index file."""
        return ((*place, *approval) for place, approval in self._by_place.items())

    def restore(self, records: Iterable[tuple[str, str, str, CommandDescription, float]]) -> None:
        """Restore the records that :meth:`records` returned."""
        for gateway, key, part, description, said_at in islice(records, MAX_APPROVALS):
            self._by_place[gateway, key, part] = Approval(description, said_at)


def approval_digest(sources: Iterable[SourceRecord]) -> str:
    """Return the digest to which an approval of all parts of *sources* would be bound."""
    return payload_digest(sorted(_descriptions(sources)))


def _descriptions(sources: Iterable[SourceRecord]) -> Iterator[tuple[PartPlace, CommandDescription]]:
    """Yield the command descriptions of the parts of each announcement that may be commanded."""
    for source in sources:
        if source.is_claimed:
            continue
        for part in source.sighting.parts:
            if any(capability.settable for capability in part.capabilities):
                yield (*source.key, part.id), CommandDescription.of(part, source.sighting.identifiers)
