"""People in the texts of routines: at home, arriving and leaving. Pure."""

from typing import Final, NamedTuple

from homebot.devices.query.terms import And, NameIs, Not, Or, Query, StateIs, TypeIs, leaves
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.support.names import spellings
from homebot.words.phrases import PERSON_IS, PERSON_MOVES
from homebot.words.vocabulary import HOUSEHOLD, HOUSEHOLD_FACTS

AT_HOME: Final = "at_home"
_ALL_AT_HOME: Final = "all_at_home"
HOME_FACTS: Final = frozenset({AT_HOME, _ALL_AT_HOME})

_FACTS: Final = {**HOUSEHOLD_FACTS, "all": HOUSEHOLD_FACTS["everybody"]}
_ROBOT: Final = frozenset({"robot"})


class PersonState(NamedTuple):
    """A person or the household, at home or away.

    Attributes:
        person: The query for the person, or the household.
        is_home: The value of *fact*.
        fact: The capability.
    """

    person: Query
    is_home: bool
    fact: str = AT_HOME

    @property
    def query(self) -> Query:
        """The query that the person matches then; unknown matches neither."""
        return And((self.person, StateIs(self.fact, "=", self.is_home)))


def read_person(text: str) -> PersonState | None:
    """Return the state *text*, such as ``Anna is home`` or ``everybody is home``; None if it is none.

    Raises:
        UsageError: It may be meant in two ways.
    """
    if (found := PERSON_IS.match(text)) is None:
        return None
    is_home = (found["where"].casefold() == "home") is not bool(found["no"])
    who = fold(found["who"])
    if found["no"] and _FACTS.get(who) == _FACTS["all"]:
        raise UsageError(f"{text!r}: write 'nobody is home' or 'not everybody is home'")
    plain = who.removeprefix("not ")
    if plain in _FACTS:
        fact = _FACTS[plain][0 if is_home else 1]
        return PersonState(HOUSEHOLD, fact.value is (who == plain), fact.capability)
    return PersonState(_person(found["who"]), is_home)


def read_move(text: str) -> PersonState | None:
    """Return the beginning state of *text*: ``Anna arrives``, ``everybody has left``; None for no move.

    Raises:
        UsageError: It is the move of one of several, which is not known.
    """
    found = PERSON_MOVES.match(text)
    if found is None or fold(found["who"]) in _ROBOT:
        return None
    who, comes = fold(found["who"]), bool(found.get("comes"))
    if who in _FACTS and _FACTS[who][0 if comes else 1] == StateIs(AT_HOME, "=", comes):
        return PersonState(HOUSEHOLD, comes)
    if who in _FACTS:
        raise UsageError(
            f"{text!r}: write 'everybody has left', 'somebody arrives', 'everybody is home', or name a person"
        )
    return PersonState(_person(found["who"]), comes)


def check_known(text: str, query: Query) -> None:
    """Check that *query* matches no person while nothing is known of them.

    Raises:
        UsageError: It does.
    """
    match query:
        case Not(term) if any(isinstance(one, StateIs) and one.capability in HOME_FACTS for one in leaves(term)):
            raise UsageError(f"{text!r} would hold as well while it is unknown; write it like 'Anna is away'")
        case And(terms) | Or(terms):
            for one in terms:
                check_known(text, one)


def starts_unknown(query: Query) -> bool:
    """Return whether a state that was unknown before may start something: that people are away, never a return."""
    return all(one.value is False for one in leaves(query) if isinstance(one, StateIs) and one.capability in HOME_FACTS)


def _person(name: str) -> Query:
    names = tuple(map(NameIs, dict.fromkeys(map(fold, spellings(name)))))
    return And((TypeIs("person", frozenset({"x_person"}), by_word=False), names[0] if len(names) == 1 else Or(names)))
