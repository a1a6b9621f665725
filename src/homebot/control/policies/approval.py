"""Approval: a device that can hurt is sent nothing until the owner approved its announcement as it is now. Pure."""

from __future__ import annotations

import shlex
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts
from homebot.control.policies.verdict import FactUsed, Verdict
from homebot.devices.always_ask import APPROVED, CHANGED, always_asks, is_approved, why_it_asks
from homebot.devices.device import Device

__all__ = ["approval_step", "concerns_approval", "judge_approval"]

NAME: Final = "approval"

_NOT_CONCERNED: Final = Verdict(NAME, allowed=True)


def concerns_approval(command: IssuedCommand) -> bool:
    """Return whether the part can hurt and has a route, so that an approval matters."""
    return bool(command.part.routes) and always_asks(command.device, command.part)


def judge_approval(command: IssuedCommand, _facts: Facts) -> Verdict:
    """Refuse everybody every command to a part that can hurt, unless the owner approved a route that takes it."""
    if not _waits(command):
        return _NOT_CONCERNED
    device = command.device
    used = FactUsed(f"{APPROVED} of {device.id}", value=False)
    why = why_it_asks(device, command.part)
    reason = f"{command.label} can hurt ({why}), and {_problem(command)}; approve it with {_advice(device)}"
    return Verdict(NAME, allowed=False, reason=reason, facts=(used,))


def approval_step(command: IssuedCommand) -> str:
    """Return the approval that *command* needs beside a right, as the first step of an advice; empty for none."""
    return f"approve it with {_advice(command.device)}, and " if _waits(command) else ""


def _waits(command: IssuedCommand) -> bool:
    approved = [route for route in command.part.routes if route.approved]
    if approved and all(any(route.can(one) for route in approved) for one in command.settings):
        return False
    return concerns_approval(command)


def _problem(command: IssuedCommand) -> str:
    """Return the reason why no approval counts for the part."""
    keys = {(route.gateway, route.key) for route in command.part.routes}
    for fact in command.device.facts:
        if fact.name == CHANGED and (fact.gateway, fact.key) in keys:
            return f"it changed since the owner approved it: {fact.value}"
    if is_approved(command.device):
        return "it was announced after the owner approved the device"
    return "the owner has not approved it"


def _advice(device: Device) -> str:
    return f"`homebot approve {shlex.quote(device.name or device.id)}`"
