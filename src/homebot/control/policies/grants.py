"""Grants: which app may command which devices, and what takes a right that names it. Pure."""

from __future__ import annotations

from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.approval import approval_step
from homebot.control.policies.facts import Facts
from homebot.control.policies.possible import depends_on_reports
from homebot.control.policies.safe_side import may_make_safe
from homebot.control.policies.verdict import Verdict
from homebot.devices.always_ask import why_it_asks
from homebot.devices.client_rights import HARMLESS
from homebot.devices.names import THING_DIRECTORY_NODE

__all__ = ["NAME", "concerns_grants", "judge_grants"]

NAME: Final = "grants"
ALWAYS_ASK: Final = "always_ask"

_NOT_CONCERNED: Final = Verdict(NAME, allowed=True)


def concerns_grants(command: IssuedCommand) -> bool:
    """Return whether the issuer may not command the part, or that depends on what is reported."""
    rights = command.rights
    return any(map(depends_on_reports, rights.acts_on)) or not rights.may_command(command.device, command.part)


def judge_grants(needs_approval: bool, command: IssuedCommand, _facts: Facts) -> Verdict:  # noqa: FBT001 - see Policy
    """Refuse a command to a device that its issuer may not command.

    An issuer that may command everything but what always asks may still do what makes the house safer: lock, stop,
    turn off. The refusal names the approval as well if one is needed.
    """
    if command.rights.may_command(command.device, command.part):
        return _NOT_CONCERNED
    why = why_it_asks(command.device, command.part)
    if not why:
        own = ", ".join(command.rights.act_scope) or "nothing"
        return Verdict(NAME, allowed=False, reason=f"{command.issuer} may not command {command.label}, only: {own}")
    if may_make_safe(command.rights, command.device, command.part, command.settings, command.trigger):
        return Verdict(ALWAYS_ASK, allowed=True, reason="it is to the safe side")
    step = approval_step(command) if needs_approval else ""
    lacks = f"{command.label} takes a right that names it ({why}), and {command.issuer} has none"
    reason = f"{lacks}; {step}{_hint(command)} gives one"
    return Verdict(ALWAYS_ASK, allowed=False, reason=reason)


def _hint(command: IssuedCommand) -> str:
    """Return the line of the configuration that lets the issuer of *command* do this, and what it may do already."""
    table = command.issuer.removeprefix("/")
    key = table if command.issuer == THING_DIRECTORY_NODE else f"apps.{table}"
    rights = command.rights
    own = [HARMLESS] if rights.acts_on_harmless else [one.removeprefix("act: ") for one in rights.act_scope]
    queries = ", ".join(f"'{one}'" for one in (*own, f'id="{command.device.id}"'))
    return f"[{key}] act = [{queries}]"
