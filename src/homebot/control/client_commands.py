"""Commands of programs outside: refused where the client has no right to the device. Pure."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.approval import approval_step
from homebot.control.policies.safe_side import may_make_safe
from homebot.devices.always_ask import why_it_asks
from homebot.devices.client_rights import (
    LOCAL_CLIENT,
    LOCAL_RIGHTS,
    ClientRights,
    issuer_of_client,
    read_scope,
)
from homebot.errors import UsageError

__all__ = ["POLICY", "client_refusal"]

POLICY: Final = "rights"
"""The policy that such a refusal names."""


def client_refusal(command: IssuedCommand, *, needs_approval: bool) -> str:
    """Return why the client that gave *command* may not command the part; empty where it may.

    Args:
        command: The command.
        needs_approval: Whether a device that can hurt needs an approval, which is then named with the right.
    """
    device, part = command.device, command.part
    try:
        rights = _rights(command.scope)
    except UsageError as exc:
        return str(exc)
    if rights.may_command(device, part):
        return ""
    asks = why_it_asks(device, part)
    if asks and may_make_safe(rights, device, part, command.settings, command.trigger):
        return ""
    right = f"""act: {f'id="{device.id}"' if asks else part.part.service_type}"""
    why = "it is not among what the client may command"
    if asks:
        why = f"such a device takes a right that names it ({asks})"
    has = f"the scope of the client is {', '.join(command.scope)}" if command.scope else "the client has no token"
    step = approval_step(command) if needs_approval else ""
    return f"{command.issuer} may not command {device.id}: {why}, and {has}; {step}{_advice(command, right)}"


def _advice(command: IssuedCommand, right: str) -> str:
    """Return where in the configuration the client gets *right*."""
    if not command.scope:
        scope = f"scope = ['read', '{right}']"
        return f"make a token: a table [door.tokens.NAME] in homebot.toml with token_file and {scope}"
    is_local = command.issuer == issuer_of_client(LOCAL_CLIENT)
    table = "door" if is_local else f"door.tokens.{command.issuer.partition(':')[2]}"
    return f"add '{right}' to that, in the table [{table}] of homebot.toml"


@lru_cache(maxsize=256)
def _rights(scope: tuple[str, ...]) -> ClientRights:
    return read_scope(scope) if scope else LOCAL_RIGHTS
