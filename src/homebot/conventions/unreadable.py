"""Values that a reader cannot read, with its expectations. Pure."""

import re
from collections.abc import Collection, Mapping
from itertools import islice
from types import MappingProxyType
from typing import Final, NamedTuple, TypeAlias, final

from homebot.conventions.secrets import names_secret
from homebot.devices.text.states import means_unknown
from homebot.devices.value import PlainValue

Readings: TypeAlias = Mapping[str, PlainValue]
"""Values by capability; see :meth:`homebot.conventions.description.Codec.read`."""

NO_READINGS: Readings = MappingProxyType({})

_MAX_SHOWN = 60
_DIGITS: Final = re.compile("[0-9]")
_new = tuple.__new__
_MAX_DIGITS = 10**20
_MAX_WORDS = 6
_MAX_FOUND = 3
_MAX_CHECKED = 1000
_NO_VALUES: Final = frozenset({"", "-", "--", "n/a", "na", "nil", "undefined"})
"""Words of devices without a value, besides those of :func:`means_unknown`."""


class Unreadable(NamedTuple):
    """A value that could not be read, and what the reader expects: words, or the texts that it knows."""

    value: object
    expects: str | Collection[str | bytes]
    is_template: bool
    """Whether a template fails, so that only ``expects`` says why."""

    def why(self, *, without_digits: bool = False) -> str:
        """Return the reason for people, on one line: ``'on': expects ON or OFF``.

        Args:
            without_digits: Whether the value has ``#`` for its digits, which may be a code.
        """
        expects = self.expects if isinstance(self.expects, str) else _choice(self.expects)
        if self.is_template:
            return expects
        value = "a secret" if isinstance(self.value, str) and names_secret(self.value) else shown(self.value)
        return f"{_DIGITS.sub('#', value) if without_digits else value}: expects {expects}"


@final
class WholePayload(str):
    """A payload in place of a value that its JSON lacks; it may be for other readers."""


FOUND: Final[list[Unreadable]] = []
"""Up to three values that the readers of one message, which do not wait, could not read; their caller empties it."""


def unreadable(value: object, expects: str | Collection[str | bytes], *, is_template: bool = False) -> Readings:
    """Record a value that the reader cannot read, unless it is none or the word of a device for none.

    Args:
        expects: What it expects in words, or the texts that it knows; of a failing template, why it fails.
    """
    if len(FOUND) >= _MAX_FOUND or isinstance(value, WholePayload):
        return NO_READINGS
    begin = value[:_MAX_CHECKED] if isinstance(value, (str, bytes)) else value
    text = begin.decode(errors="replace") if isinstance(begin, bytes) else begin
    if is_template or not _is_no_value(text):
        FOUND.append(_new(Unreadable, (text, expects, is_template)))
    return NO_READINGS


def _is_no_value(value: object) -> bool:
    if not isinstance(value, str):
        return value is None
    return value.strip().lower() in _NO_VALUES or means_unknown(value)


def _choice(words: Collection[str | bytes]) -> str:
    texts = [word.decode() if isinstance(word, bytes) else word for word in islice(words, _MAX_WORDS + 3)]
    known = [text[:_MAX_SHOWN] for text in texts if text and text != "None"]
    if len(known) > _MAX_WORDS + 1:
        return f"{', '.join(known[:_MAX_WORDS])} or {len(words) - _MAX_WORDS} others"
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
        if value is None or isinstance(value, bool) or (isinstance(value, int) and abs(value) < _MAX_DIGITS):
            text = str(value)
    return text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}…"
