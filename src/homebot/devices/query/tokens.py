"""The tokens of a text query. Pure."""

import re
from dataclasses import dataclass
from typing import Literal, TypeAlias

from homebot.errors import UsageError

MAX_QUERY = 1000
"""The limit of characters of a query."""

MAX_TOKENS = 100

TokenKind: TypeAlias = Literal["word", "text", "operator", "(", ")", ","]


@dataclass(frozen=True, slots=True)
class Token:
    """A piece of a query.

    Attributes:
        kind: ``word``, ``text`` (in quotes), ``operator`` (a comparison), a bracket or a comma.
        at: The position of its first character, counted from 1.
    """

    kind: TokenKind
    text: str
    at: int


_PIECE = re.compile(
    r"""\s*(?:
        (?P<text>"(?:[^"\\]|\\.)*"|'[^']*') |
        (?P<operator><=|>=|!=|==|[=<>:≤≥≠]|(?i:(?:is\s+)?(?:below|under|above|over))(?=\s+[+-]?\d)) |
        (?P<bracket>[(),]) |
        (?P<word>(?:[^\s"'(),=<>:!≤≥≠]|!(?!=))(?:[^\s"(),=<>:!≤≥≠]|!(?!=))*)
    )""",
    re.VERBOSE | re.DOTALL,
)
_SPELT: dict[str, str] = {"==": "=", ":": "=", "≤": "<=", "≥": ">=", "≠": "!="}
_SPELT |= {"below": "<", "under": "<", "above": ">", "over": ">"}


def quoted(text: str) -> str:
    """Return *text* quoted as a value for a query; it may contain any characters."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def tokens_of(text: str) -> tuple[Token, ...]:
    """Return the tokens of *text*.

    Raises:
        UsageError: It is too long, or a character does not begin a token; names the position.
    """
    if len(text) > MAX_QUERY:
        raise UsageError(f"the query has {len(text):,} characters; {MAX_QUERY:,} is the limit")
    tokens: list[Token] = []
    end, place = len(text.rstrip()), 0
    while place < end:
        piece = _PIECE.match(text, place)
        if piece is None:
            rest = text[place:].lstrip()
            problem = "an unclosed quotation mark" if rest[0] in "\"'" else "not allowed in a query"
            raise UsageError(f"character {end - len(rest.rstrip()) + 1} of the query, {rest[:1]!r}, is {problem}")
        tokens.append(_token(piece))
        place = piece.end()
        if len(tokens) > MAX_TOKENS:
            raise UsageError(f"the query has more than {MAX_TOKENS} words")
    return tuple(tokens)


def _token(piece: re.Match[str]) -> Token:
    kind = piece.lastgroup or ""
    found, at = piece.group(kind), piece.start(kind) + 1
    match kind, found:
        case "operator", _:
            return Token("operator", _SPELT.get(found.lower().split()[-1], found), at)
        case "bracket", ("(" | ")" | ",") as bracket:
            return Token(bracket, found, at)
        case "text", _:
            inner = found[1:-1]
            return Token("text", re.sub(r"\\(.)", r"\1", inner, flags=re.DOTALL) if found[0] == '"' else inner, at)
        case _:
            return Token("word", found, at)
