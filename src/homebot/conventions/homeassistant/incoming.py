"""One message of a device, as all its parts that read it share it. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from homebot.conventions.jinja import PayloadContext
from homebot.conventions.payload import MAX_LONG_STATE_BYTES

__all__ = ["StateMessage"]


class StateMessage:
    """One payload. Its JSON is parsed at most once, when the first part asks for it.

    Attributes:
        payload: The bytes.
        retained: Whether the broker had kept it from before.
    """

    __slots__ = ("payload", "retained")

    def __init__(self, payload: bytes, *, retained: bool = False) -> None:
        self.payload = payload
        self.retained = retained

    def context(self, encoding: str = "utf-8") -> PayloadContext | None:
        """Return what a template sees; None where the payload is no such text, or longer than what is looked at.

        Args:
            encoding: As :attr:`DiscoveryConfig.encoding` has it; empty where payloads are no text.
        """
        return _context(self.payload, encoding)

    def text(self, encoding: str = "utf-8") -> str | None:
        """Return the payload as text; None as for :meth:`context`."""
        context = _context(self.payload, encoding)
        return None if context is None else context.value

    def json_object(self, encoding: str = "utf-8") -> Mapping[str, object] | None:
        """Return the JSON object that the payload is; None where it is none."""
        context = _context(self.payload, encoding)
        value = None if context is None else context.value_json
        return value if isinstance(value, dict) else None


@lru_cache(maxsize=2)
def _context(payload: bytes, encoding: str) -> PayloadContext | None:
    if len(payload) > MAX_LONG_STATE_BYTES or not encoding:
        return None
    try:
        return PayloadContext(payload.decode(encoding))
    except UnicodeDecodeError:
        return None
