"""Counters of a gateway of any protocol. Pure."""

from dataclasses import dataclass

__all__ = ["GatewayCounters"]


@dataclass(slots=True)
class GatewayCounters:
    """The counters of one gateway since its start; counters that its protocol lacks stay 0.

    Attributes:
        rejected: Messages that no device can have sent.
        commands: Commands that the network took.
        commands_refused: Commands that were refused, by us or by the network.
        commands_failed: Commands that found no link.
        announcements: Messages in which devices were announced or taken back.
        announcements_ambiguous: Those with a key twice in their JSON.
        announcements_rejected: Those that broke the rules of their convention.
        announcements_derived: Those of devices that the list of their bridge describes, which are not registered.
        announcements_deferred: Those that had to wait because too much that came where they did broke the rules.
        devices_refused: Descriptions that were one too many, had too many parts, or were too long for them.
        topics_refused: Addresses of states that are not listened to.
        topics_reserved: Addresses of commands that were announced and belong to no device.
        types_refused: Times that a service type was announced and not looked for, because there were too many.
        addresses_refused: Network addresses that were dropped because their host announces too many.
        readings_refused: Values that no described part can have reported.
        oversize: Messages that were too long to be looked at.
        failures: Times that a convention raised an unexpected exception.
        asks: Questions to devices for their state.
        asks_dropped: Questions that were one too many.
        expiries_dropped: Values that do not end by themselves because too many others do.
        quarantines: Times that a peer, or a group of them, began to be read a little at a time.
    """

    received: int = 0
    rejected: int = 0
    commands: int = 0
    commands_refused: int = 0
    commands_failed: int = 0
    announcements: int = 0
    announcements_ambiguous: int = 0
    announcements_rejected: int = 0
    announcements_derived: int = 0
    announcements_deferred: int = 0
    devices_refused: int = 0
    topics_refused: int = 0
    topics_reserved: int = 0
    types_refused: int = 0
    addresses_refused: int = 0
    reports: int = 0
    readings_refused: int = 0
    oversize: int = 0
    failures: int = 0
    asks: int = 0
    asks_dropped: int = 0
    expiries_dropped: int = 0
    quarantines: int = 0
