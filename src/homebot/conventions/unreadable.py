"""Values that a reader expects and cannot read, with what it expects. Pure."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final, NamedTuple, TypeAlias, final

from homebot.conventions.secrets import names_secret
from homebot.devices.text.states import means_unknown
from homebot.devices.value import PlainValue

__all__ = ["FOUND", "NO_READINGS", "Readings", "Unreadable", "WholePayload", "shown", "unreadable"]

Readings: TypeAlias = Mapping[str, PlainValue]
"""Values by capability; see :meth:`homebot.conventions.description.Codec.read`."""

NO_READINGS: Readings = MappingProxyType({})

_MAX_SHOWN = 60
_MOST_DIGITS = 10**20
_MOST_WORDS = 6
_MOST_FOUND = 3
_NO_VALUES: Final = frozenset({"", "-", "--", "n/a", "na", "nil", "undefined"})
"""Words of devices without a value, besides those of :func:`means_unknown`."""


class Unreadable(NamedTuple):
    """A value that could not be read.

    Attributes:
        value: The value on one line, shortened; empty for a failing template.
        expects: What the reader expects, in words.
    """

    value: str
    expects: str

    @property
    def why(self) -> str:
        """The reason for people: ``'on': expects ON or OFF``."""
        return f"{self.value}: expects {self.expects}" if self.value else self.expects


@final
class WholePayload(str):
    """A payload in place of a value that its JSON lacks; it may be for other readers."""

    __slots__ = ()


FOUND: Final[list[Unreadable]] = []
"""What readers could not read, at most three values, until somebody who had a message read empties it.

Readers do not wait, so all are of one message; and it is no context variable, which would cost each message two calls.
"""


def unreadable(value: object, expects: str | Iterable[str | bytes], *, is_template: bool = False) -> Readings:
    """Record a value that the reader cannot read; return no readings.

    What is no value is not recorded: null, an empty text, words such as ``unknown``, and a :class:`WholePayload`.

    Args:
        expects: What it expects in words, or the texts that it knows.
        is_template: Whether *expects* is the reason why a template failed, and *value* is not shown.
    """
    if len(FOUND) >= _MOST_FOUND or (not is_template and _is_no_value(value)):
        return NO_READINGS
    text = value.decode(errors="replace") if isinstance(value, bytes) else value
    is_secret = isinstance(text, str) and names_secret(text)
    words = expects if isinstance(expects, str) else _choice(expects)
    FOUND.append(Unreadable("" if is_template else "a secret" if is_secret else shown(text), words))
    return NO_READINGS


def _is_no_value(value: object) -> bool:
    if isinstance(value, (str, bytes)):
        text = value.decode(errors="replace") if isinstance(value, bytes) else value
        return isinstance(value, WholePayload) or text.strip().lower() in _NO_VALUES or means_unknown(text)
    return value is None


def _choice(words: Iterable[str | bytes]) -> str:
    texts = [one.decode() if isinstance(one, bytes) else one for one in words]
    known = [text[:_MAX_SHOWN] for text in texts if text and text != "None"]
    if len(known) > _MOST_WORDS + 1:
        return f"{', '.join(known[:_MOST_WORDS])} or {len(known) - _MOST_WORDS} others"
    return " or ".join(filter(None, (", ".join(known[:-1]), *known[-1:])))


def shown(value: object) -> str:
    """Return *value* for an error message: short, on one line."""
    if isinstance(value, (str, bytes)):
        value = value[: _MAX_SHOWN + 1]
        text = repr(value)
    elif isinstance(value, (dict, list)):
        text = f"{type(value).__name__} of {len(value)}"
    else:
        text = f"{value:.6g}" if isinstance(value, float) else type(value).__name__
        if value is None or isinstance(value, bool) or (isinstance(value, int) and abs(value) < _MOST_DIGITS):
            text = str(value)
    return text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}…"
