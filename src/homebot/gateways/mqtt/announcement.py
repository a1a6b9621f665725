"""One announcement that stands: what it says of its device, and how that device was last heard. Pure."""

from __future__ import annotations

from dataclasses import dataclass, field

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.devices.names import text_address
from homebot.gateways.announced.last_messages import PartTexts
from homebot.gateways.announced.reachability import ReachabilityReader
from homebot.gateways.announced.reported_device import ReportedDevice, sighting_template

__all__ = ["AnnouncedPart", "AvailabilityReader", "StoredAnnouncement"]


@dataclass(slots=True, eq=False)
class AnnouncedPart(PartTexts):
    """One part of a described device, as it speaks.

    Attributes:
        stored: Whose part it is.
        described: The part.
        address: Where it is listened to: its words address, or the topic on which it says text by itself.
    """

    stored: StoredAnnouncement
    described: DescribedPart
    address: str


@dataclass(frozen=True, slots=True, eq=False)
class AvailabilityReader:
    """One topic that tells whether a described device, or one of its parts, can be reached.

    Attributes:
        stored: Whose availability.
        part: Which part; empty for the whole.
        index: Which of its sources.
    """

    stored: StoredAnnouncement
    part: str
    index: int


@dataclass(slots=True, eq=False)
class StoredAnnouncement(ReportedDevice):
    """One announcement that stands.

    Attributes:
        described: What it says.
        parts: Its parts by id.
        reachability: What is known of whether the device (``""``) and its parts can be reached, as far as they tell.
        excess: Bytes by which it is longer than what it offers explains.
        subscriptions: The filters that it is read on, each with who reads.
    """

    described: DeviceAnnounced
    excess: int = 0
    parts: dict[str, AnnouncedPart] = field(init=False)
    reachability: dict[str, ReachabilityReader] = field(init=False)
    subscriptions: list[tuple[str, AnnouncedPart | AvailabilityReader]] = field(default_factory=list)

    def __post_init__(self) -> None:
        described, text = self.described, self.described.text
        self.parts = {
            one.part.id: AnnouncedPart(self, one, text_address(self.key, one.part.id) if text is None else text.address)
            for one in described.parts
        }
        told = [("", described.availability)]
        told += [(one.part.id, one.availability) for one in described.parts if one.availability is not None]
        self.reachability = {part: ReachabilityReader(one) for part, one in told if one is not None and one.sources}
        # Made here, so that what cannot be told is found at once.
        self.template = sighting_template(
            self.gateway,
            self.key,
            name=described.name,
            parts=tuple([one.part for one in described.parts if one.part.service_type]),
            metadata=described.facts,
            identifiers=described.identifiers,
            area=described.area,
            convention=described.convention if text is None else "",
            native=described.native or text is not None,
            whole_device=described.whole_device,
            owns=described.owns,
            announced_on=described.topic if text is None else "",
            text=text,
        )

    def take_over_state(self, before: StoredAnnouncement) -> None:
        """Take over what is known of the device from the announcement *before* this one."""
        self.is_confirmed = before.is_confirmed
        self.refresh_at = before.refresh_at
        self.report_streams = before.report_streams
        self.reachable = {part: told for part, told in before.reachable.items() if part in self.reachability}
        for part, reachability in self.reachability.items():
            old_one = before.reachability.get(part)
            if old_one is not None and old_one.availability == reachability.availability:
                self.reachability[part] = old_one
        for part_id, announced_part in self.parts.items():
            if (old := before.parts.get(part_id)) is not None:
                announced_part.kept = old.kept

    def let_go(self) -> None:
        """Forget its parts, which know it: what stands no more must not wait for the collector of circular garbage."""
        self.parts, self.reachability, self.subscriptions = {}, {}, []
