"""The counters of a gateway of any protocol. Pure."""

from dataclasses import dataclass

from homebot.support.counters import fault, loss


@dataclass(slots=True)
class GatewayCounters:
    """The counters of one gateway since its start; those that do not apply to its protocol stay 0.

    Attributes:
        rejected: Invalid messages of devices.
        commands: Commands that the network accepted.
        commands_refused: Commands refused by homebot or by the network.
        commands_failed: Commands that failed for lack of a link or an answer.
        announcements: Messages that announce or withdraw devices.
        announcements_ambiguous: Announcements with duplicate keys in their JSON.
        announcements_rejected: Announcements that broke the rules of their convention.
        announcements_derived: Announcements left out because the bridge's list already describes the device.
        announcements_deferred: Announcements that waited because their source, or its group, broke the rules too often.
        devices_refused: Descriptions that exceeded a limit: of devices, parts or length.
        topics_refused: State addresses that could not be subscribed to.
        topics_reserved: Announced command addresses that are reserved.
        types_refused: Announced service types that were not browsed, because there were too many.
        addresses_refused: Network addresses dropped because their host announces too many.
        readings_refused: Reported values that do not fit the described part.
        oversize: Messages too long to be read.
        payloads_unreadable: Values of devices that do not fit their announcement, by part.
        failures: Unexpected exceptions of conventions.
        asks: Requests to devices for their state.
        asks_dropped: Such requests dropped because too many were queued.
        expiries_dropped: Values that will not expire, because too many others are waiting to.
        quarantines: Quarantines begun, of a peer or of a group.
    """

    received: int = 0
    rejected: int = fault()
    commands: int = 0
    commands_refused: int = fault()
    commands_failed: int = loss()
    announcements: int = 0
    announcements_ambiguous: int = 0
    announcements_rejected: int = fault()
    announcements_derived: int = 0
    announcements_deferred: int = fault()
    devices_refused: int = fault()
    topics_refused: int = fault()
    topics_reserved: int = 0
    types_refused: int = fault()
    addresses_refused: int = fault()
    reports: int = 0
    readings_refused: int = fault()
    oversize: int = fault()
    payloads_unreadable: int = 0
    failures: int = loss()
    asks: int = 0
    asks_dropped: int = loss()
    expiries_dropped: int = loss()
    quarantines: int = fault()
