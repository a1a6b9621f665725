"""The tokens of what people write, and forms of words over them. Pure.

The work for a text is bounded by its length times that of the form.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal, NamedTuple, TypeAlias, final

from homebot.errors import UsageError
from homebot.words.amounts import UNITS, read_amount

MAX_QUERY = 1000
"""The limit of characters of a query, and of any other text."""

MAX_TOKENS = 100

TokenKind: TypeAlias = Literal["word", "text", "operator", "(", ")", ",", "?"]


@dataclass(frozen=True, slots=True)
class Token:
    """A piece of a text.

    Attributes:
        kind: ``word``, ``text`` (in quotes), ``operator`` (a comparison), a bracket, a comma, or ``?`` for a character
            that begins none of these.
        at: The position of its first character, counted from 1.
        end: The position after its last character, counted from 0.
    """

    kind: TokenKind
    text: str
    at: int
    end: int = 0


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
    """Return the tokens of the query *text*.

    Raises:
        UsageError: It is too long, or a character does not begin a token; names the position.
    """
    tokens = _pieces_of(text)
    if (stray := next((token for token in tokens if token.kind == "?"), None)) is not None:
        problem = "an unclosed quotation mark" if stray.text in "\"'" else "not allowed in a query"
        raise UsageError(f"character {stray.at} of the query, {stray.text!r}, is {problem}")
    if len(tokens) > MAX_TOKENS:
        raise UsageError(f"the query has more than {MAX_TOKENS} words")
    return tokens


@lru_cache(maxsize=256)  # many forms are tried on one text
def _pieces_of(text: str) -> tuple[Token, ...]:
    if len(text) > MAX_QUERY:
        raise UsageError(f"the query has {len(text):,} characters; {MAX_QUERY:,} is the limit")
    tokens: list[Token] = []
    end, place = len(text.rstrip()), 0
    while place < end:
        if (piece := _PIECE.match(text, place)) is None:
            at = end - len(text[place:end].lstrip())
            tokens.append(Token("?", text[at], at + 1, at + 1))
        else:
            tokens.append(_token(piece))
        place = tokens[-1].end
    return tuple(tokens)


def _token(piece: re.Match[str]) -> Token:
    kind = piece.lastgroup or ""
    found, at, end = piece.group(kind), piece.start(kind) + 1, piece.end()
    match kind, found:
        case "operator", _:
            return Token("operator", _SPELT.get(found.lower().split()[-1], found), at, end)
        case "bracket", ("(" | ")" | ",") as bracket:
            return Token(bracket, found, at, end)
        case "text", _:
            inner = found[1:-1]
            value = re.sub(r"\\(.)", r"\1", inner, flags=re.DOTALL) if found[0] == '"' else inner
            return Token("text", value, at, end)
        case _:
            return Token("word", found, at, end)


class _Part(NamedTuple):
    """A part of a form.

    Attributes:
        name: The name of its value; empty for a word without one.
        words: The words of which it is one; empty for a slot.
        kind: The kind of a slot; see :class:`Phrase`.
    """

    name: str
    words: frozenset[str]
    kind: str
    is_optional: bool


_NUMBER_WORDS: Final = frozenset({"half", "a", "an", "one"})


_Spans: TypeAlias = tuple[tuple[_Part, int, int], ...]


@final
class Phrase:
    """A form of words, such as ``{robot:word} go|goes to [the] {room}``.

    ``go|goes`` is one of these words in any case, ``[the]`` may be missing, ``no~not`` has a name. A slot ``{room}`` is
    one token or more, as few as possible: ``{robot:word}`` is a single word, ``{name:one}`` one or a text in quotes,
    ``{count:number}`` begins with a digit or a sign, ``{value:amount}`` has a unit at most, and
    ``{length:length}`` is a length of time without a comma, or another text that begins with a digit.

    Args:
        texts: The forms, of which the first that fits counts.
    """

    def __init__(self, *texts: str) -> None:
        self._forms: list[list[_Part]] = []
        for text in texts:
            parts: list[_Part] = []
            for word in text.split():
                plain, is_optional = word.strip("[]"), word.startswith("[")
                if plain.startswith("{"):
                    name, _, kind = plain.strip("{}").partition(":")
                    parts.append(_Part(name, frozenset(), kind or "any", is_optional))
                else:
                    name, _, words = plain.rpartition("~")
                    parts.append(_Part(name, frozenset(words.split("|")), "", is_optional))
            self._forms.append(parts)

    def match(self, text: str) -> Mapping[str, str] | None:
        """Return the values of *text* by name, empty for what is missing; None if it has another form.

        Raises:
            UsageError: It is longer than :data:`MAX_QUERY`.
        """
        tokens = _pieces_of(text)
        for parts in self._forms:
            if (spans := _match(parts, tokens, text)) is None:
                continue
            values = {part.name: "" for part in parts if part.name}
            for part, first, end in spans:
                values[part.name] = text[tokens[first].at - 1 : tokens[end - 1].end]
                if part.kind in _WHOLE and not _WHOLE[part.kind](values[part.name]):
                    break
            else:
                return values
        return None


def _match(parts: Sequence[_Part], tokens: Sequence[Token], text: str) -> _Spans | None:
    """Return the named ones of *parts*, each with its first token and the one after its last; None for another form."""
    # Steps to try, the next one last: the part, the token, where its open slot began, and the values before.
    steps: list[tuple[int, int, int | None, _Spans]] = [(0, 0, None, ())]
    tried: set[tuple[int, int, bool]] = set()
    while steps:
        place, at, begin, values = steps.pop()
        if (place, at, begin is None) in tried:
            continue
        tried.add((place, at, begin is None))
        if place == len(parts):
            if at == len(tokens):
                return values
            continue
        part = parts[place]
        if part.is_optional and not part.kind:
            steps.append((place + 1, at, None, values))
        if at < len(tokens) and _fits(part, tokens, at, text, is_first=begin is None):
            if part.kind in {"", "word", "one"}:
                steps.append((place + 1, at + 1, None, (*values, (part, at, at + 1)) if part.name else values))
            else:
                steps.append((place, at + 1, at if begin is None else begin, values))
        if begin is not None:
            steps.append((place + 1, at, None, (*values, (part, begin, at))))
        elif part.is_optional and part.kind:
            steps.append((place + 1, at, None, values))
    return None


def _fits(part: _Part, tokens: Sequence[Token], at: int, text: str, *, is_first: bool) -> bool:
    """Return whether the token *at* may be the word of *part*, or the first or a further one of its slot."""
    token = tokens[at]
    if at and is_first and _is_attached(token, tokens[at - 1]):
        return False
    match part.kind:
        case "":
            is_word = token.kind != "text" and token.text.casefold() in part.words
            return is_word or text[token.at - 1 : token.end].casefold() in part.words  # `over 5m` is no comparison
        case "word" | "one":
            is_word = token.kind == "word" and token.text.replace("-", "a").replace("_", "a").isalnum()
            return is_word or (part.kind == "one" and token.kind == "text")
        case "number" | "amount" if is_first:
            return token.text.lstrip("+-")[:1].isdecimal()
        case "length" if is_first:
            return token.text[:1].isdecimal() or token.text.casefold() in _NUMBER_WORDS
        case "length":
            return token.kind != ","
    return True


def _is_attached(token: Token, before: Token) -> bool:
    """Return whether *token* follows *before* without a blank, as in ``lock=jammed``; commas and ``=`` stand apart."""
    return before.end == token.at - 1 and "," not in {before.text, token.text} and token.text != "="


def _is_length(text: str) -> bool:
    """Return whether *text* is a length of time, or begins with a digit, so that it should be one."""
    if text[0].isdecimal():
        return True
    from homebot.units import parse_duration  # noqa: PLC0415 - loads pydantic

    with suppress(UsageError):
        return parse_duration(text) > 0
    return False


def _is_amount(text: str) -> bool:
    amount = read_amount(text)
    return amount is not None and amount.unit in {"", *UNITS.values()}


_WHOLE: Final[Mapping[str, Callable[[str], bool]]] = {"length": _is_length, "amount": _is_amount}
"""The tests of whole slots."""


def split_at(text: str, *words: str) -> list[str]:
    """Return the parts of *text* between each of *words*, which may be a comma, outside of brackets and quotes."""
    parts, begin, depth = [], 0, 0
    for token in _pieces_of(text):
        depth += (token.kind == "(") - (token.kind == ")")
        if not depth and token.kind in {"word", ","} and token.text.casefold() in words:
            parts.append(text[begin : token.at - 1].strip())
            begin = token.end
    return [*parts, text[begin:].strip()]


def replaced(text: str, word: str, by: str) -> str:
    """Return *text* with *by* for each *word* in just these letters outside of quotes, also in braces."""
    pieces, begin = [], 0
    for token in _pieces_of(text):
        if token.kind == "word" and token.text.strip("{}") == word:
            place = token.at - 1 + token.text.index(word)
            pieces += [text[begin:place], by]
            begin = place + len(word)
    return "".join([*pieces, text[begin:]])


_STEP_JOINT: Final = re.compile(r" ?[;,] ?(?:(?:and|then) )*| (?:(?:and|then) )+", re.IGNORECASE)
_CODE: Final = re.compile(r"\b(?:code|pin)\b\W*\d", re.IGNORECASE)


def split_steps(text: str) -> list[str]:
    """Return the parts of *text* between commas, semicolons, ``and`` and ``then``."""
    return _STEP_JOINT.split(text)


def has_code(text: str) -> bool:
    """Return whether *text* tells a code or PIN."""
    return _CODE.search(text) is not None
