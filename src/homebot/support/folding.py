"""Comparison of words without case, accents and punctuation, and tolerating a typo. Pure."""

import re
import unicodedata
from functools import lru_cache

MAX_WORD = 40
"""Characters of a word that count."""

WORD_TYPO = 4
"""Shortest word in which one typo is forgiven."""

_ROOM_TYPO = 3
_MAX_TEXT = 400
_WORD = re.compile(r"\w+")
_LETTERS = {"ß": "ss", "æ": "ae", "œ": "oe", "ø": "o", "đ": "d", "ł": "l"}
_TABLE = str.maketrans(_LETTERS)


@lru_cache(maxsize=4096)
def fold(text: str) -> str:
    """Return *text* in lower case without accents, with each run of blanks, ``_`` and ``-`` as one blank.

    Only its first 400 characters count.
    """
    plain = text[:_MAX_TEXT]
    if not plain.isascii():
        decomposed = unicodedata.normalize("NFKD", plain.casefold().translate(_TABLE))
        plain = "".join(character for character in decomposed if not unicodedata.combining(character))
    return " ".join(plain.lower().replace("_", " ").replace("-", " ").split())


@lru_cache(maxsize=4096)
def words_of(text: str) -> tuple[str, ...]:
    """Return the folded words of *text*, each once, in order."""
    words = _WORD.findall(fold(text))
    if max(map(len, words), default=0) > MAX_WORD:
        words = [word[:MAX_WORD] for word in words]
    return tuple(dict.fromkeys(words))


def may_be_typo(word: str, shortest: int = WORD_TYPO) -> bool:
    """Return whether a typo in *word* is tolerated: not in short words and numbers."""
    return len(word) >= shortest and word.isalpha()


def is_room_typo(room: str, other: str) -> bool:
    """Return whether the folded *room* is *other* with a typo, even in a short name or a blank, as rooms are few."""
    return is_typo(room.replace(" ", ""), other.replace(" ", ""), _ROOM_TYPO)


def is_typo(word: str, other: str, shortest: int = WORD_TYPO) -> bool:
    """Return whether *word* is *other* with one letter added, removed, changed or swapped with its neighbour.

    False for equal words, and for words shorter than *shortest* or with digits, where a typo makes another word.
    """
    if word == other or abs(len(word) - len(other)) > 1:
        return False
    if not (may_be_typo(word, shortest) and may_be_typo(other, shortest)):
        return False
    start = 0
    shorter = min(len(word), len(other))
    while start < shorter and word[start] == other[start]:
        start += 1
    rest, other_rest = sorted((word[start:], other[start:]), key=len)
    if len(rest) < len(other_rest):
        return rest == other_rest[1:]
    return rest[1:] == other_rest[1:] or (rest[1::-1] == other_rest[:2] and rest[2:] == other_rest[2:])
