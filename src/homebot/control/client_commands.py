"""Commands of programs outside: refused where the client has no right to the device. Pure."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from homebot.devices import Device, DevicePart
from homebot.devices.always_ask import always_asks
from homebot.devices.client_rights import LOCAL_RIGHTS, ClientRights, is_client, read_scope
from homebot.devices.command_messages import CommandRequest
from homebot.errors import UsageError

__all__ = ["POLICY", "client_refusal"]

POLICY: Final = "rights"
"""The policy that such a refusal names."""


def client_refusal(request: CommandRequest, device: Device, part: DevicePart) -> str:
    """Return why the issuer of *request* may not command *part* of *device*; empty where it may, or is no client."""
    if not is_client(request.issuer):
        return ""
    try:
        rights = _rights(request.scope)
    except UsageError as exc:
        return str(exc)
    if rights.may_command(device, part):
        return ""
    asks = always_asks(device, part)
    has = ", ".join(request.scope) or "no token"
    query = f'id="{device.id}"' if asks else part.part.service_type
    why = "it always asks, and" if asks else "it is not among what it may command:"
    hint = f"'act: {query}' in the scope of a token allows it"
    return f"{request.issuer} may not command {device.id}: {why} the client has {has}; {hint}"


@lru_cache(maxsize=256)
def _rights(scope: tuple[str, ...]) -> ClientRights:
    return read_scope(scope) if scope else LOCAL_RIGHTS
