"""Removal of secrets from recordings. Pure."""

import json
import re
from typing import Final

from pydantic import BaseModel, SecretBytes, SecretStr

HIDDEN: Final = "***"
"""Replaces a secret."""

_WORDS: Final = frozenset(
    {
        *("code", "pin", "password", "passwd", "passphrase", "passcode", "psk", "token", "secret", "credential"),
        *("credentials", "key", "apikey", "authorization"),
    }
)
_LOGIN: Final = re.compile(r"(?<=://)[^\s/@]+(?=@)")
"""User and password in a URL."""

_MAX_BYTES: Final = 256 * 1024


def is_secret_name(name: str) -> bool:
    """Return whether the field *name* is named like a secret, such as ``pin`` or ``wifi_password``."""
    plain = "".join(character if character.isalnum() else "_" for character in name.casefold())
    return any(part in _WORDS for part in plain.split("_"))


def public_settings(settings: BaseModel) -> dict[str, object]:
    """Return *settings* as JSON values, without secrets."""
    public: dict[str, object] = settings.model_dump(mode="json", by_alias=True, exclude_unset=True)
    hidden = {
        name for name in settings.model_fields_set if isinstance(getattr(settings, name, None), SecretStr | SecretBytes)
    }
    return {name: _clean(value) for name, value in public.items() if name not in hidden and not is_secret_name(name)}


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
            return _LOGIN.sub(HIDDEN, value)
    return value
