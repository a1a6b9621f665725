"""Rights and approvals: the devices that an issuer may command, and those that need the owner's approval. Pure."""

import shlex
from collections.abc import Mapping
from functools import lru_cache
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.command_pattern import VERBS
from homebot.control.policies.facts import Facts, FactUsed, Verdict
from homebot.devices.always_ask import APPROVED, CHANGED, is_approved, is_arming, is_opener
from homebot.devices.client_rights import (
    HARMLESS,
    LOCAL_CLIENT,
    LOCAL_RIGHTS,
    ClientRights,
    issuer_of_client,
    read_scope,
)
from homebot.devices.device import Device, DevicePart
from homebot.devices.names import THING_DIRECTORY_NODE
from homebot.devices.value import PlainValue
from homebot.errors import UsageError

__all__ = ["check_approval", "check_grants", "client_refusal", "is_safe"]

GRANTS: Final = "grants"
ALWAYS_ASK: Final = "always_ask"
APPROVAL: Final = "approval"

_GRANTED: Final = Verdict(GRANTS, allowed=True)
_APPROVED: Final = Verdict(APPROVAL, allowed=True)

_SAFE: Final = ("lock", "turn off")
_SAFE_SETTING: Final = ("lock",)
"""Off is unsafe for a setting such as a lock's auto-lock, for a part that arms the alarm, and for a door opener: some
models move the door at either value."""


def check_grants(needs_approval: bool, command: IssuedCommand, _facts: Facts) -> Verdict:  # noqa: FBT001 - bound by a partial
    """Refuse a command to a device that its issuer may not command.

    Without a right that names a dangerous device, an issuer may still lock, stop or turn it off.
    """
    why = command.why_it_asks
    if command.rights.may_command(command.device, command.part, asks=bool(why)):
        return _GRANTED
    if not why:
        own = ", ".join(command.rights.act_scope) or "nothing"
        own += _place_advice(command.device, own)
        return Verdict(GRANTS, allowed=False, reason=f"{command.issuer} may not command {command.label}, only: {own}")
    if _may_make_safe(command, command.rights):
        return Verdict(ALWAYS_ASK, allowed=True, reason="it makes the house safer")
    step = _approval_step(command) if needs_approval else ""
    lacks = f"{command.label} needs a right that names it ({why}), and {command.issuer} has none"
    return Verdict(ALWAYS_ASK, allowed=False, reason=f"{lacks}; {step}{_grant_advice(command)} gives one")


def check_approval(command: IssuedCommand, _facts: Facts) -> Verdict:
    """Refuse every command to a dangerous part, unless the owner approved a route that takes it."""
    device, why = command.device, command.why_it_asks
    if not (why and _waits_for_approval(command)):
        return _APPROVED
    used = FactUsed(f"{APPROVED} of {device.id}", value=False)
    reason = f"{command.label} is unsafe ({why}), and {_missing_approval(command)}; approve it with {_approve(device)}"
    return Verdict(APPROVAL, allowed=False, reason=reason, facts=(used,))


def client_refusal(command: IssuedCommand, *, needs_approval: bool) -> str:
    """Return why the client that gave *command* may not command the part; empty if it may.

    Args:
        needs_approval: Whether dangerous devices need an approval; if so, the reason names it along with the right.
    """
    device, part, asks = command.device, command.part, command.why_it_asks
    try:
        rights = _rights(command.scope)
    except UsageError as exc:
        return str(exc)
    if rights.may_command(device, part, asks=bool(asks)):
        return ""
    if asks and _may_make_safe(command, rights):
        return ""
    right = f"""act: {f'id="{device.id}"' if asks else part.part.service_type}"""
    why = (
        f"such a device needs a right that names it ({asks})" if asks else "it is not among what the client may command"
    )
    scope = ", ".join(command.scope)
    has = f"the scope of the client is {scope}" if scope else "no token of the client is known"
    step = _approval_step(command) if asks and needs_approval else ""
    has += _place_advice(device, scope)
    return f"{command.issuer} may not command {device.id}: {why}, and {has}; {step}{_client_advice(command, right)}"


def is_safe(device: Device, part: DevicePart, settings: Mapping[str, PlainValue]) -> bool:
    """Return whether all *settings* make the house safer: closing a valve does, closing a door may hurt a person."""
    is_off_unsafe = part.part.service_type == "x_setting" or is_opener(device) or is_arming(part)
    verbs = _SAFE_SETTING if is_off_unsafe else _SAFE
    return all(
        any(VERBS[verb](name, value, None) for verb in verbs) or _is_always_safe(name, value)
        for name, value in settings.items()
    )


def _is_always_safe(name: str, value: PlainValue) -> bool:
    is_armed = name == "alarm" and isinstance(value, str) and value.startswith("armed")
    return value == "stopped" or (name, value) == ("valve", "closed") or is_armed


def _may_make_safe(command: IssuedCommand, rights: ClientRights) -> bool:
    """Return whether *rights* to all harmless devices allow a command to a dangerous one.

    A lease is not allowed: it would block issuers that have the right to the device.
    """
    is_lease = command.trigger.kind == "lease"
    return rights.acts_on_harmless and not is_lease and is_safe(command.device, command.part, command.settings)


def _place_advice(device: Device, scope: str) -> str:
    """Return that a device without a room is in none that *scope* names; empty if it is not that."""
    is_nowhere = " in " in scope and not device.area
    return f"; it has no room: homebot place {shlex.quote(device.name or device.id)} ROOM" if is_nowhere else ""


def _grant_advice(command: IssuedCommand) -> str:
    """Return the line of the configuration that also lets the issuer command this device."""
    table = command.issuer.removeprefix("/")
    key = table if command.issuer == THING_DIRECTORY_NODE else f"apps.{table}"
    rights = command.rights
    own = [HARMLESS] if rights.acts_on_harmless else [one.removeprefix("act: ") for one in rights.act_scope]
    queries = ", ".join(f"'{one}'" for one in (*own, f'id="{command.device.id}"'))
    return f"[{key}] act = [{queries}]"


def _client_advice(command: IssuedCommand, right: str) -> str:
    """Return the place in the configuration that gives the client *right*."""
    if not command.scope:
        return f"make a token: homebot token new NAME --scope read --scope {shlex.quote(right)}"
    is_local = command.issuer == issuer_of_client(LOCAL_CLIENT)
    table = "door" if is_local else f"door.tokens.{command.issuer.partition(':')[2]}"
    return f"add '{right}' to that, in the table [{table}] of homebot.toml"


@lru_cache(maxsize=256)
def _rights(scope: tuple[str, ...]) -> ClientRights:
    return read_scope(scope) if scope else LOCAL_RIGHTS


def _approval_step(command: IssuedCommand) -> str:
    """Return the missing approval as the first step to take; empty if none is missing."""
    return f"approve it with {_approve(command.device)}, and " if _waits_for_approval(command) else ""


def _waits_for_approval(command: IssuedCommand) -> bool:
    routes = command.part.routes
    approved = [route for route in routes if route.approved]
    return bool(routes) and not (approved and all(any(one.can(name) for one in approved) for name in command.settings))


def _missing_approval(command: IssuedCommand) -> str:
    """Return why no approval applies to the part."""
    keys = {(route.gateway, route.key) for route in command.part.routes}
    for fact in command.device.facts:
        if fact.name == CHANGED and (fact.gateway, fact.key) in keys:
            return f"it changed since the owner approved it: {fact.value}"
    if is_approved(command.device):
        return "it was announced after the owner approved the device"
    return "the owner has not approved it"


def _approve(device: Device) -> str:
    return f"`homebot approve {shlex.quote(device.name or device.id)}`"
