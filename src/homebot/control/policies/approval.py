"""Approval: a device that can hurt is not driven until the owner approved it. Pure."""

from __future__ import annotations

import shlex
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts
from homebot.control.policies.safe_side import is_safe
from homebot.control.policies.verdict import FactUsed, Verdict
from homebot.devices.always_ask import APPROVED, always_asks, is_approved, why_it_asks
from homebot.devices.device import Device

__all__ = ["approval_step", "concerns_approval", "judge_approval"]

NAME: Final = "approval"

_NOT_CONCERNED: Final = Verdict(NAME, allowed=True)


def concerns_approval(command: IssuedCommand) -> bool:
    """Return whether the part can hurt and its device is not approved."""
    return always_asks(command.device, command.part) and not is_approved(command.device)


def judge_approval(command: IssuedCommand, _facts: Facts) -> Verdict:
    """Refuse everybody a command to a part that can hurt, of a device that is not approved, but to the safe side."""
    device = command.device
    if not concerns_approval(command):
        return _NOT_CONCERNED
    if is_safe(device, command.part, command.settings):
        return Verdict(NAME, allowed=True, reason="it is to the safe side")
    used = FactUsed(f"{APPROVED} of {device.id}", value=False)
    why = why_it_asks(device, command.part)
    reason = f"{command.label} can hurt ({why}), and the owner has not approved it; approve it with {_advice(device)}"
    return Verdict(NAME, allowed=False, reason=reason, facts=(used,))


def approval_step(command: IssuedCommand) -> str:
    """Return the approval that *command* needs beside a right, as the first step of an advice; empty for none."""
    return f"approve it with {_advice(command.device)}, and " if concerns_approval(command) else ""


def _advice(device: Device) -> str:
    return f"`homebot approve {shlex.quote(device.name or device.id)}`"
