"""Removal of secrets from recordings. Pure."""

import json
from typing import Final

from pydantic import BaseModel

from homebot.support.key_roles import KeyRole, is_secret_name, role_of, without_login

HIDDEN: Final = "***"
"""Replaces a secret."""

_MAX_BYTES: Final = 256 * 1024


def public_settings(settings: BaseModel) -> dict[str, object]:
    """Return *settings* as JSON values, without secrets."""
    public: dict[str, object] = settings.model_dump(mode="json", by_alias=True, exclude_unset=True)
    fields = {field.alias or name: field for name, field in type(settings).model_fields.items()}
    hidden = {name for name, field in fields.items() if role_of(name, field) is KeyRole.SECRET}
    return {name: _clean(value) for name, value in public.items() if name not in hidden}


def without_secrets(payload: bytes) -> bytes:
    """Return a raw *payload*; in JSON, fields named like secrets and logins in URLs are hidden.

    A payload of more than 256 kB is not parsed, and therefore left out.
    """
    if len(payload) > _MAX_BYTES:
        return b""
    if payload.lstrip()[:1] not in {b"{", b"["}:
        return payload
    try:
        content = json.loads(payload)
    except (ValueError, RecursionError):
        return payload
    cleaned = _clean(content)
    return payload if cleaned == content else json.dumps(cleaned, separators=(",", ":")).encode()


def _clean(value: object) -> object:
    match value:
        case dict():
            return {name: HIDDEN if is_secret_name(str(name)) else _clean(item) for name, item in value.items()}
        case list():
            return [_clean(item) for item in value]
        case str():
            return without_login(value, f"{HIDDEN}@")
    return value
