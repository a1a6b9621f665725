"""Leases as messages for people and programs. Pure."""

from __future__ import annotations

from homebot.control.leases import Lease
from homebot.devices.lease_messages import HeldPart, HolderOfPart
from homebot.messages import Time

__all__ = ["held_part"]


def held_part(lease: Lease, monotonic: float, now: float) -> HeldPart:
    """Return *lease* as it is at *monotonic* seconds of that clock, which are *now* seconds since the Unix epoch."""

    def time(at: float) -> Time:
        return Time.from_seconds(now + at - monotonic)

    device, part = lease.part
    is_outranked = monotonic < lease.hand_until
    return HeldPart(
        device=device,
        part=part,
        setting=lease.setting,
        holders=tuple(
            HolderOfPart(by=holder.by, issuer=issuer, until=time(holder.deadline))
            for (issuer, _, _), holder in lease.holders.items()
        ),
        outranked_until=time(lease.hand_until) if is_outranked else Time(sec=0, nanosec=0),
        saw=lease.saw if is_outranked else "",
    )
