"""Rights and approvals: the devices that an issuer may command, and those that need the owner's approval. Pure."""

import shlex
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, Verdict
from homebot.devices.always_ask import (
    APPROVED,
    CHANGED,
    is_approved,
    is_arming,
    is_of_known_load,
    is_opener,
    why_it_asks,
)
from homebot.devices.client_rights import EDIT_ROUTINE, HARMLESS, LOCAL_CLIENT, ORDINARY, ClientRights, issuer_of_client
from homebot.devices.device import Device, DevicePart
from homebot.devices.device_lookup import references
from homebot.devices.harmless import why_not_covered
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.value import PlainValue
from homebot.errors import UsageError
from homebot.support.toml_text import toml_value
from homebot.words.patterns import VERBS
from homebot.words.rights import rights_of

GRANTS: Final = "grants"
ALWAYS_ASK: Final = "always_ask"
APPROVAL: Final = "approval"

OF_RIGHTS: Final = frozenset({GRANTS, ALWAYS_ASK, HARMLESS})
"""The policies by which a right is missing."""

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
    why, rights = command.why_it_asks, command.rights
    if rights.acts_on_ordinary and (not why or rights.acts_on_all):
        return _GRANTED  # as nearly always
    limit = why_not_covered(rights, command.device, command.part, command.why_it_asks, command.settings)
    if limit is None:
        return _GRANTED
    if limit and _may_make_safe(command, rights):
        return Verdict(ALWAYS_ASK, allowed=True, reason="it makes the house safer")
    why, rights = command.why_it_asks, command.rights
    advice = _grant_advice(command)
    if why:
        step = _approval_step(command) if needs_approval else ""
        lacks = f"{command.label} needs a right that names it ({why}), and {command.issuer} has none"
        return Verdict(ALWAYS_ASK, allowed=False, reason=f"{lacks}; {step}{advice}")
    if limit:
        lacks = f"{command.label} needs a right, because {_unlisted(limit)}, and {command.issuer} has none"
        return Verdict(HARMLESS, allowed=False, reason=f"{lacks}; {_tag_advice(command.device)}{advice}")
    own = ", ".join(rights.act_scope) or "nothing"
    own += _place_advice(command.device, own)
    own += f"; {advice}" if rights.table.startswith(EDIT_ROUTINE) else ""  # others were limited by hand
    return Verdict(GRANTS, allowed=False, reason=f"{command.issuer} may not command {command.label}, only: {own}")


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
    try:
        rights = rights_of(command.scope)
    except UsageError as exc:
        return str(exc)
    if command.trigger.kind == "lease" and must_ask(command):
        return f"a person must agree to each command of {command.issuer} to {command.device.id}, so it cannot hold it"
    limit = why_not_covered(rights, command.device, command.part, command.why_it_asks, command.settings)
    if limit is None or (_may_make_safe(command, rights) if limit else _may_command_members(command)):
        return ""
    return _refusal_text(command, limit, needs_approval=needs_approval)


def _refusal_text(command: IssuedCommand, limit: str, *, needs_approval: bool) -> str:
    device, part, asks = command.device, command.part, command.why_it_asks
    right = f"""act: {f'id="{device.id}"' if limit else part.part.service_type}"""
    why = _unlisted(limit) if limit else "it is not among what the client may command"
    why = f"such a device needs a right that names it ({asks})" if asks else why
    scope = ", ".join(command.scope)
    has = f"the scope of the client is {scope}" if scope else "no token of the client is known"
    step = _approval_step(command) if asks and needs_approval else ""
    step += _tag_advice(device) if limit and not asks else ""
    has += _place_advice(device, scope)
    return f"{command.issuer} may not command {device.id}: {why}, and {has}; {step}{_client_advice(command, right)}"


def must_ask(command: IssuedCommand) -> bool:
    """Return whether a person must agree to *command*: a client gave it whose right for the part is ``ask``.

    For a raw text that no part explains, all parts count.
    """
    if not command.is_client:
        return False
    try:
        rights = rights_of(command.scope)
    except UsageError:
        return True
    device, part = command.device, command.part
    parts = device.parts if device.part(part.id) is None else (part,)
    return any(rights.must_ask(device, part) for part in parts)


def names_it(command: IssuedCommand) -> bool:
    """Return whether a right of its issuer fits its part by a query, not as all that is harmless or ordinary does."""
    try:
        rights = rights_of(command.scope) if command.is_client else command.rights
    except UsageError:
        return False
    facets = PartFacets(command.device, command.part)
    return any(fits(query, facets) for query in rights.acts_on + rights.asks_on)


def is_safe(device: Device, part: DevicePart, settings: Mapping[str, PlainValue], *, knows_load: bool = True) -> bool:
    """Return whether all *settings* make the house safer: closing a valve does, closing a door may hurt a person.

    Args:
        knows_load: Whether it is known what the part turns off; if not, it may be a freezer, or keep a person alive.
    """
    is_off_unsafe = part.part.service_type == "x_setting" or is_opener(device) or is_arming(part) or not knows_load
    verbs = _SAFE_SETTING if is_off_unsafe else _SAFE
    return all(
        any(VERBS[verb](name, value, None) for verb in verbs) or _is_always_safe(name, value)
        for name, value in settings.items()
    )


def why_asked(device: Device, part: DevicePart, values: Mapping[str, PlainValue]) -> str:
    """Return why a person must agree to *values*; empty if none must. To lock, or to shut off water, is safe."""
    reason = why_it_asks(device, part)
    is_harmless = bool(values) and "alarm" not in values and is_safe(device, part, values)
    return "" if is_harmless else reason


def _is_always_safe(name: str, value: PlainValue) -> bool:
    is_armed = name == "alarm" and isinstance(value, str) and value.startswith("armed")
    return value == "stopped" or (name, value) == ("valve", "closed") or is_armed


def _may_make_safe(command: IssuedCommand, rights: ClientRights) -> bool:
    """Return whether *rights* to all harmless devices allow a command to another one.

    A lease is not allowed: it would block issuers that have the right to the device.
    """
    device, part, is_lease = command.device, command.part, command.trigger.kind == "lease"
    knows_load = rights.acts_on_ordinary or bool(command.why_it_asks and is_of_known_load(device, part))
    return rights.acts_on_harmless and not is_lease and is_safe(device, part, command.settings, knows_load=knows_load)


def _may_command_members(scene: IssuedCommand) -> bool:
    """Return whether all that a scene of a bridge names as its members is known, and its client may command it."""
    parts = (scene.part, *(part for _, part in scene.members))
    gateways = {route.gateway for part in parts for route in part.routes}
    known = {name for device, part in scene.members for name in references(device, part, gateways)}
    return (
        scene.part.part.service_type == "x_scene"
        and bool(scene.members)
        and known.issuperset(name for part in parts for name in part.part.members)
        and not any(
            client_refusal(replace(scene, device=device, part=part, members=()), needs_approval=False)
            for device, part in scene.members
        )
    )


def _unlisted(limit: str) -> str:
    return f"it is not on the list of harmless devices ({limit})"


def _tag_advice(device: Device) -> str:
    """Return the command that puts *device* on the list of harmless devices."""
    return f"if it can hurt nobody, `homebot tag add {shlex.quote(device.name or device.id)} {HARMLESS}`, otherwise "


def _place_advice(device: Device, scope: str) -> str:
    """Return that a device without a room is in none that *scope* names; empty if it is not that."""
    is_nowhere = " in " in scope and not device.area
    return f"; it has no room: homebot place {shlex.quote(device.name or device.id)} ROOM" if is_nowhere else ""


def _grant_advice(command: IssuedCommand) -> str:
    """Return the line of the configuration, or the command, that also lets the issuer command this device."""
    rights, query = command.rights, f'id="{command.device.id}"'
    if not rights.table:
        return "only an app or a routine can have one, by its key `act`"
    if rights.table.startswith(EDIT_ROUTINE):
        return f"`{rights.table} --act {shlex.quote(query)}` gives one"
    scope = [right.removeprefix("act: ") for right in rights.act_scope]
    own = scope or [ORDINARY if rights.acts_on_ordinary else HARMLESS] * rights.acts_on_harmless
    queries = [f"'{right}'" if "'" not in right else toml_value(right) for right in (*own, query)]
    return f"{rights.table} act = [{', '.join(queries)}] gives one"


def _client_advice(command: IssuedCommand, right: str) -> str:
    """Return the place in the configuration that gives the client *right*."""
    if not command.scope:
        return f"make a token: homebot token new NAME --scope read --scope {shlex.quote(right)}"
    is_local = command.issuer == issuer_of_client(LOCAL_CLIENT)
    table = "door" if is_local else f"door.tokens.{command.issuer.partition(':')[2]}"
    return f"add '{right}' to that, in the table [{table}] of homebot.toml"


def _approval_step(command: IssuedCommand) -> str:
    """Return the missing approval as the first step to take; empty if none is missing."""
    return f"approve it with {_approve(command.device)}, and " if _waits_for_approval(command) else ""


def _waits_for_approval(command: IssuedCommand) -> bool:
    routes = command.part.routes
    approved = [route for route in routes if route.approved]
    return bool(routes) and not (
        approved and all(any(route.can(name) for route in approved) for name in command.settings)
    )


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
