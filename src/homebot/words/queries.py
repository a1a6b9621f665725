"""Text queries: ``light and dimmable in kitchen``, ``on lights``, ``sensor with temperature not stale``. Pure.

Grammar, the loosest binding first::

    query      = all {"or" all}
    all        = one {["and" | "," | "but"] one}, after "but" with "not" or "without"
    one        = "not" one | "(" query ")" | "in" AREA | near | with | comparison | word
    with       = ("with" | "without") (CAPABILITY | condition | comparison | "area")
    near       = "near" ROBOT ["within" METRES] | "within" METRES "of" ROBOT
    comparison = NAME ("=" | "!=" | "<" | "below" | "<=" | ">" | "above" | ">=") VALUE
    word       = a type, a capability, an adjective such as ``on`` or ``stale``, or free text

Words in quotation marks are literal: ``"near the door"`` searches for words, ``"zone"=3`` for a fact of that name,
``type="coffee"`` for devices with that announced type. Without them, an unknown field or type is an error. An adjective
of a state applies to parts of the types next to it: ``on lights`` does not match because of a plug in the same device.
``heating`` is an adjective next to a type, and otherwise a type: ``heating in living``.

If the names of a house are known, words that are exactly the name of one of its devices, beside nothing but states,
mean that device: ``tv on`` is about the plug called TV, and ``Treppe unten on`` not about the Treppe unter Dach. A part
that is called like a type that it is not is meant likewise, unless something of the type may have such states.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from itertools import accumulate
from typing import TypeAlias

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES, wanted_types
from homebot.devices.query.terms import (
    And,
    AreaIs,
    CanDo,
    Exists,
    FreshnessIs,
    HasText,
    InArea,
    IsDisputed,
    IsNear,
    IsUnapproved,
    NameIs,
    Not,
    Or,
    PartIs,
    Query,
    ReachableIs,
    StateIs,
    lasting,
    leaves,
    split_near,
)
from homebot.errors import UsageError
from homebot.support.folding import MAX_WORD, fold, words_of
from homebot.support.names import did_you_mean
from homebot.words.amounts import UNITS, read_amount
from homebot.words.comparisons import comparison
from homebot.words.tokens import Token, tokens_of
from homebot.words.vocabulary import (
    ADJECTIVES,
    CAPABILITY_WORDS,
    CONDITIONS,
    FILLERS,
    KEYWORDS,
    NOT_UNDERSTOOD,
    RELATIVES,
    all_of,
    is_meaningful,
    meaning_of,
)

Term: TypeAlias = tuple[Query, str, bool]
"""A term with its text, and whether ``and``, ``but`` or a comma precedes it."""

_Span: TypeAlias = tuple[Query, int, int, bool]
"""A term, with the indices of its first token and after its last, and whether it is joined as a ``Term``."""

_NOWHERE = AreaIs("")
"""Matches a device without a known room."""

_OF_NAMED = AreaIs | CanDo | FreshnessIs | InArea | IsDisputed | IsUnapproved | ReachableIs | StateIs

_AREA_WORDS = ("area", "room", "areas", "rooms")
_METRES = ("m", "metres", "meters", "metre", "meter")
_MAX_DEPTH = 20
_MAX_PHRASE = 5
_MAX_NAME_WORDS = 12
_MAX_MEANINGS = 100
_CONTRACTED = re.compile(r"\b(what|where|who)['\u2019]s\b", re.IGNORECASE)
_REQUEST = re.compile(r"\A(?:please )?(?:list|(?:show|give|tell) me) (?=\S)", re.IGNORECASE)
"""The words before a query in a sentence, which are none of its own."""

_VERBS = frozenset({"are", "is"})


def parse_query(text: str, exists: Exists | None = None) -> Query:
    """Parse *text* as a query; an empty text matches everything.

    Args:
        exists: For a known house: words that are exactly the name of a device or room mean what is called so.

    Raises:
        UsageError: It is not a query; the message names the part that is not understood, and an alternative.
    """
    return _parse(text) if exists is None else _Parser(text, exists).query()


def parse_in_any_house(text: str) -> Query:
    """Parse *text* as a query for all that it means in one house or another, whatever is called there how.

    Raises:
        UsageError: As for :func:`parse_query`, or it means too much.
    """
    return _Parser(text, lambda _: False, is_any=True).query()


@lru_cache(maxsize=256)  # apps repeat their queries
def _parse(text: str) -> Query:
    return _Parser(text).query()


def names_in(text: str) -> frozenset[str]:
    """Return the words of the query *text* that may be the name of something, folded."""
    parser = _Parser(text)
    return frozenset(name for place in range(len(parser.ends) - 1) for _, name in parser.names_at(place))


def parse_alternatives(text: str) -> tuple[tuple[Term, ...], ...]:
    """Return the alternatives joined by ``or`` outside parentheses in *text*, each as its terms.

    Raises:
        UsageError: As for :func:`parse_query`.
    """
    if parse_query(text) == And(()):
        return ((),)
    parser = _Parser(text)
    return tuple(
        tuple((term, parser.text(first, last), joined) for term, first, last, joined in terms)
        for terms in parser.alternatives()
    )


class _Parser:
    def __init__(self, text: str, exists: Exists | None = None, *, is_any: bool = False) -> None:
        self._text = _CONTRACTED.sub(r"\1 is", _REQUEST.sub("", text.strip().removesuffix("?")))
        self._tokens = tokens_of(self._text)
        self._is_any, self._is_denied = is_any, False
        self._known_states: dict[int, tuple[Query | None, int]] = {}
        self._no_states = set[int]()  # places from which on there are others too
        self._exists = self._is_known = exists
        self.ends = [*(token.at - 1 for token in self._tokens), len(self._text)]
        self._place = 0
        self._depth = 0

    def text(self, first: int, last: int) -> str:
        """Return the text of the tokens from *first* until before *last*."""
        return self._text[self.ends[first] : self.ends[last]].strip()

    def names_at(self, place: int) -> Iterator[tuple[int, str]]:
        """Yield the words from *place* on that may be a name, the longest first, each with the place after them."""
        for end in range(min(place + _MAX_NAME_WORDS, len(self._tokens)), place, -1):
            if self._is_balanced(place, end):
                yield end, fold(self.text(place, end))

    def _is_balanced(self, first: int, last: int) -> bool:
        """Return whether no bracket around the tokens from *first* until before *last* begins or ends in them."""
        depths = [*accumulate((token.kind == "(") - (token.kind == ")") for token in self._tokens[first:last])]
        return not depths or (min(depths) == 0 and depths[-1] == 0)

    def query(self) -> Query:
        if not self._tokens:
            return And(())
        found = self._any()
        if (extra := self._peek()) is not None:
            raise UsageError(f"{extra.text!r} at character {extra.at} has no opening bracket")
        split_near(found)
        return found

    def alternatives(self) -> list[list[_Span]]:
        found = [self._terms()]
        while self._takes("or"):
            found.append(self._terms())
        return found

    def _any(self) -> Query:
        alternatives = [self._all()]
        while self._takes("or"):
            alternatives.append(self._all())
        return alternatives[0] if len(alternatives) == 1 else Or(tuple(alternatives))

    def _all(self) -> Query:
        return self._meanings() if self._is_any and self._exists is not None else self._meaning()

    def _meanings(self) -> Query:
        """Parse what is meant if any of the words are a name: a device fits if it fits one, or a denied one all."""
        first = self._place
        meanings, end = [self._meaning()], self._place
        for exists in (NameIs.__instancecheck__, PartIs.__instancecheck__):
            self._place = first
            for named, is_open in self._readings(exists):
                if self._place == end or (not is_open and self._is_balanced(end, self._place)):
                    meanings.append(named)
                if len(meanings) > _MAX_MEANINGS:
                    raise UsageError(f'the query may mean more than {_MAX_MEANINGS} things; write name="…" for a name')
        self._place = end
        return meanings[0] if len(meanings) == 1 else (And if self._is_denied else Or)(tuple(meanings))

    def _meaning(self) -> Query:
        first = self._place
        named = None if self._exists is None else self._named(self._exists)
        if named is not None and not named[1]:
            return named[0]
        end, self._place = self._place, first
        plain = all_of([term for term, *_ in self._terms()])
        if named is None or self._place != end:
            return plain
        if any(isinstance(one, PartIs) for one in leaves(named[0])):
            is_type = self._exists is not None and self._exists(lasting(plain))
            return plain if is_type else named[0]
        return Or((named[0], plain))

    def _named(self, exists: Exists) -> tuple[Query, bool] | None:
        """Parse a name and its states; return also whether others are meant too, as by a type and a room.

        None if nothing has the name and may have such states.
        """
        return next((reading for reading in self._readings(exists) if exists(lasting(reading[0]))), None)

    def _readings(self, exists: Exists) -> Iterator[tuple[Query, bool]]:
        """Parse a name that *exists* and its states in each possible way, as :meth:`_named`."""
        states: list[Query] = []
        while (token := self._peek()) is not None:
            place = self._place
            for end, name in self.names_at(place):
                called: NameIs | PartIs = NameIs(name)
                if exists(called) or exists(called := PartIs(name)):
                    self._place = end
                    if (others := self._states()) is not None:
                        is_part, said = type(called) is PartIs, (*states, *others)
                        named = And((called, *(_of_part(one, name) if is_part else one for one in said)))
                        is_open = is_part or any(isinstance(term, AreaIs | InArea) for term in leaves(named))
                        yield named, is_open and any(map(is_meaningful, name.split()))
                    self._place = place
            if self._is_filler(token):
                self._place += 1
            elif (state := self._state()) is not None:
                states.append(state)
            else:
                return

    def _states(self) -> list[Query] | None:
        """Parse what may be said of a device with a name; None if something else follows."""
        states, passed = list[Query](), list[int]()
        while (token := self._peek()) is not None and token.kind != ")" and not _is(token, "or"):
            passed.append(self._place)
            if self._place not in self._no_states and (_joins(token) or self._is_filler(token)):
                self._place += 1
            elif self._place not in self._no_states and (state := self._state()) is not None:
                states.append(state)
            else:
                self._no_states.update(passed)
                return None
        return states

    def _state(self) -> Query | None:
        begun = self._place
        if begun not in self._known_states:
            self._known_states[begun] = self._parse_state(), self._place
        state, self._place = self._known_states[begun]
        return state

    def _parse_state(self) -> Query | None:
        begun = self._place, self._depth, self._exists, self._is_denied
        self._exists = None
        term: Query | None = None
        with suppress(UsageError):  # the whole is parsed otherwise, and then it is raised
            term = self._one()
        if term is not None and all(isinstance(one, _OF_NAMED) for one in leaves(term)):
            self._exists = begun[2]
            return term
        self._place, self._depth, self._exists, self._is_denied = begun
        return None

    def _terms(self) -> list[_Span]:
        terms: list[_Span] = []
        is_open, is_joined = True, False
        while (token := self._peek()) is not None and token.kind != ")" and not _is(token, "or"):
            if _joins(token):
                if is_open:
                    raise _missing(token)
                self._place += 1
                self._check_exception(token)
                is_open = is_joined = True
                continue
            if self._is_filler(token):
                is_open = False
                self._place += 1
                continue
            first = self._place
            terms.append((self._one(), first, self._place, bool(terms) and is_joined))
            is_open = is_joined = False
        if is_open:
            raise _missing(self._peek() or self._tokens[-1])
        return terms

    def _one(self) -> Query:
        token = self._tokens[self._place]
        word = "(" if token.kind == "(" else fold(token.text) if token.kind == "word" else ""
        parse = _BEGINNINGS.get(word)
        if parse is not None and not (word in _FIELD_NAMES and self._is_compared()):
            self._place += 1
            return parse(self, token)
        if token.kind not in {"word", "text"}:
            raise UsageError(f"{token.text!r} at character {token.at} has no name before it")
        if self._is_compared():
            return comparison(*self._read_comparison())
        if token.kind == "word":
            return self._phrase()
        self._place += 1
        return _all_words(token.text)

    def in_area(self, token: Token) -> Query:
        words: list[str] = []
        while (following := self._peek()) is not None and following.kind in {"word", "text"}:
            word = fold(following.text)
            if following.kind == "text":
                if not words:
                    self._place += 1
                    words.append(word)
                break
            if self._is_compared() or _ends_area(word, words):
                break
            self._place += 1
            if word != "the" or words:
                words.append(word)
        if not words:
            raise UsageError(f"{token.text!r} at character {token.at} is not followed by an area")
        area = " ".join(words)
        return AreaIs(area) if self._is_known is not None and self._is_known(AreaIs(area)) else InArea(area)

    def within(self, token: Token) -> Query:
        within = self._metres(token)
        if not (self._takes("of") or self._takes("from")):
            raise UsageError(f"{token.text!r} at character {token.at} is not followed by metres 'of' a robot")
        return IsNear(self._robot(token), within)

    def with_ability(self, token: Token) -> Query:
        if self._is_compared():
            return self._one()
        return Not(_NOWHERE) if self._takes_area() else self._ability(token)

    def negated(self, token: Token) -> Query:
        following = self._peek()
        if following is None or following.kind == ")" or _is(following, "or"):
            raise _missing(token)
        with_capability = fold(token.text) == "without" and not self._is_compared()
        if with_capability and self._takes_area():
            return _NOWHERE
        self._enter(token)
        self._is_denied = not self._is_denied
        term = self._ability(token) if with_capability else self._one()
        self._is_denied = not self._is_denied
        self._depth -= 1
        return Not(term)

    def bracket(self, token: Token) -> Query:
        self._enter(token)
        found = self._any()
        self._depth -= 1
        closing = self._peek()
        if closing is None or closing.kind != ")":
            raise UsageError(f"the bracket at character {token.at} is never closed")
        self._place += 1
        return found

    def _enter(self, token: Token) -> None:
        self._depth += 1
        if self._depth > _MAX_DEPTH:
            raise UsageError(f"the query is nested deeper than {_MAX_DEPTH} at character {token.at}")

    def _read_comparison(self) -> tuple[Token, Token, Token]:
        length = self._length_of_name()
        *words, operator = self._tokens[self._place : self._place + length + 1]
        name = replace(words[0], text=" ".join([one.text for one in words]))
        self._place += length + 1
        value = self._peek()
        if value is None or value.kind not in {"word", "text"}:
            raise UsageError(f"'{name.text} {operator.text}' is not followed by a value")
        self._place += 1
        if value.kind == "word" and value.text[-1:].isdigit():
            for length in (2, 1):  # per cent
                unit = " ".join([token.text for token in self._tokens[self._place : self._place + length]])
                if self._peek_folded(length) and (symbol := UNITS.get(unit) or UNITS.get(unit.casefold(), "")):
                    self._place += length
                    value = replace(value, text=value.text + symbol)
                    break
        return name, operator, value

    def _is_compared(self) -> bool:
        return self._length_of_name() > 0

    def _is_filler(self, token: Token) -> bool:
        if token.kind != "word" or self._is_compared():
            return False
        word = fold(token.text)
        if word in FILLERS:
            return not any(self._peek_folded(length) in ADJECTIVES for length in (2, 3, 4))  # as in: anna is home
        return word in RELATIVES and self._peek_folded(2).endswith((" is", " are"))

    def _length_of_name(self) -> int:
        """Return the number of words before an operator: one, or those of a capability; 0 if no operator follows."""
        for length in range(1, _MAX_PHRASE + 1):
            following = self._tokens[self._place + length : self._place + length + 1]
            if following and following[0].kind == "operator":
                return length if length == 1 or self._peek_folded(length) in CAPABILITY_WORDS else 0
        return 0

    def near(self, token: Token) -> Query:
        robot = self._robot(token)
        within = self._peek()
        return IsNear(robot, self._metres(within) if within is not None and self._takes("within") else math.inf)

    def _robot(self, token: Token) -> str:
        self._takes("the")
        named = self._peek()
        if named is None or named.kind not in {"word", "text"} or fold(named.text) in KEYWORDS | NOT_UNDERSTOOD:
            raise UsageError(f"{token.text!r} at character {token.at} is not followed by a robot")
        self._place += 1
        return named.text

    def _metres(self, token: Token) -> float:
        """Parse a length, after *token*: ``5 m``, ``5m``, or ``5``."""
        given = self._peek()
        length = None if given is None or given.kind != "word" else read_amount(given.text.lower())
        if length is None or length.unit not in {"", *_METRES} or not length.number[0].isdecimal():
            raise UsageError(f"{token.text!r} at character {token.at} is not followed by metres, such as '5 m'")
        self._place += 1
        if not length.unit:
            any(self._takes(unit) for unit in _METRES)
        return float(length.number)

    def _ability(self, token: Token) -> Query:
        for length in range(_MAX_PHRASE, 0, -1):
            phrase = self._peek_folded(length)
            if phrase in CAPABILITY_WORDS or phrase in CONDITIONS:
                self._place += length
                return CanDo(CAPABILITY_WORDS[phrase]) if phrase in CAPABILITY_WORDS else CONDITIONS[phrase]
        following = self._peek()
        if following is None:
            raise _missing(token)
        raise _unknown_capability(following)

    def _phrase(self) -> Query:
        """Parse the longest phrase with a meaning; a single word without one is searched for."""
        for length in range(_MAX_PHRASE, 0, -1):
            if (meant := meaning_of(self._peek_folded(length))) is not None:
                self._place += length
                return meant
        token = self._tokens[self._place]
        if token.text[0] in "!¬~-" and (token.text[1:2].isalpha() or token.text[1:2] == "_"):
            raise UsageError(
                f"{token.text!r} at character {token.at} is not understood in a query; write 'not' before a term"
            )
        if fold(token.text) in NOT_UNDERSTOOD:
            raise UsageError(
                f"{token.text!r} at character {token.at} is not understood in a query; write it in quotation marks if "
                f"it is part of a name"
            )
        self._place += 1
        return _all_words(token.text)

    def _check_exception(self, joint: Token) -> None:
        """Refuse ``lights but kettle``, which would only find the kettle."""
        following = self._peek()
        if _is(joint, "but") and following is not None and not (_is(following, "not") or _is(following, "without")):
            raise UsageError(f"'but' at character {joint.at} is not followed by 'not' or 'without'")

    def _peek_folded(self, length: int) -> str:
        tokens = self._tokens[self._place : self._place + length]
        is_phrase = len(tokens) == length and all(one.kind == "word" for one in tokens)
        return fold(" ".join(one.text for one in tokens)) if is_phrase else ""

    def _takes(self, keyword: str) -> bool:
        token = self._peek()
        if token is None or not _is(token, keyword):
            return False
        self._place += 1
        return True

    def _takes_area(self) -> bool:
        return any(self._takes(word) for word in _AREA_WORDS)

    def _peek(self) -> Token | None:
        return self._tokens[self._place] if self._place < len(self._tokens) else None


_BEGINNINGS: Mapping[str, Callable[[_Parser, Token], Query]] = {
    "not": _Parser.negated,
    "without": _Parser.negated,
    "in": _Parser.in_area,
    "near": _Parser.near,
    "within": _Parser.within,
    "with": _Parser.with_ability,
    "(": _Parser.bracket,
}
"""Parsers of terms by their first word, which has been read."""

_FIELD_NAMES = frozenset({"in", "near"})
"""The words among these that are field names if an operator follows."""


def _ends_area(word: str, words: list[str]) -> bool:
    """Return whether *word* cannot be part of a room name that begins with *words*."""
    return word in KEYWORDS | NOT_UNDERSTOOD or (bool(words) and (word in _VERBS | RELATIVES or is_meaningful(word)))


def _of_part(query: Query, name: str) -> Query:
    """Return *query* with its states as those of the parts with the *name*."""
    match query:
        case And(terms) | Or(terms):
            return type(query)(tuple(_of_part(term, name) for term in terms))
        case Not(term):
            return Not(_of_part(term, name))
        case StateIs():
            return replace(query, part=name)
        case _:
            return query


def _all_words(text: str) -> Query:
    words = [HasText(word[:MAX_WORD]) for word in words_of(text)]
    if not words:
        raise UsageError(f"{text[:40]!r} contains no search term")
    return words[0] if len(words) == 1 else And(tuple(words))


def _is(token: Token, keyword: str) -> bool:
    return token.kind == "word" and token.text.lower() == keyword


def _joins(token: Token) -> bool:
    return _is(token, "and") or _is(token, "but") or token.kind == ","


def _missing(token: Token) -> UsageError:
    return UsageError(f"a term is missing next to {token.text!r} at character {token.at}")


def _unknown_capability(token: Token) -> UsageError:
    word = fold(token.text)
    known = f"known are {', '.join(sorted(CAPABILITIES)[:12])}, …"
    hint = did_you_mean(word, CAPABILITY_WORDS, known, cutoff=0.6)
    is_type = bool(wanted_types(" ".join(word.split()))) or word in DEVICE_TYPES
    hint = f"it is a type of device: leave out the word before it; {hint}" if is_type else hint
    return UsageError(f"{token.text[:40]!r} at character {token.at} is not a capability; {hint}")
