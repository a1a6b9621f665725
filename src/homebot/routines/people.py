"""People in the texts of routines: at home, arriving and leaving. Pure."""

import re
from typing import Final, NamedTuple

from homebot.devices.query.terms import And, NameIs, Not, Or, Query, StateIs, TypeIs, leaves
from homebot.errors import UsageError
from homebot.support.folding import fold

__all__ = ["AT_HOME", "PersonState", "check_known", "may_begin", "read_move", "read_person"]

AT_HOME: Final = "at_home"

_IS: Final = re.compile(r"(?P<who>.+?)\s+(?:is|are)\s+(?P<no>not\s+)?(?:at\s+)?(?P<where>home|away)", re.IGNORECASE)
_MOVES: Final = re.compile(
    r"(?P<who>.+?)\s+(?:(?P<comes>arrives?|comes?)(?:\s+home)?|(?:leaves?|has left|have left|goes away)(?:\s+home)?)",
    re.IGNORECASE,
)
_SOMEBODY: Final = frozenset({"somebody", "someone", "anybody", "anyone"})
_NOBODY: Final = frozenset({"nobody", "no one", "no-one"})
_EVERYBODY: Final = frozenset({"everybody", "everyone", "all"})
_ROBOT: Final = frozenset({"robot"})


class PersonState(NamedTuple):
    """A person or the household, at home or away.

    Attributes:
        person: The query for the person, or the household.
    """

    person: Query
    is_home: bool

    @property
    def query(self) -> Query:
        """The query that the person matches then; unknown matches neither."""
        return And((self.person, StateIs(AT_HOME, "=", self.is_home)))


def read_person(text: str) -> PersonState | None:
    """Return the state *text*, such as ``Anna is home``; None if it is none.

    Raises:
        UsageError: It cannot be known of all of them together.
    """
    if (found := _IS.fullmatch(text)) is None:
        return None
    is_home = (found["where"].casefold() == "home") is not bool(found["no"])
    who = fold(found["who"])
    if who in _NOBODY and not found["no"] and is_home:
        return PersonState(_household(), is_home=False)
    if (who in _SOMEBODY and is_home and not found["no"]) or (who in _EVERYBODY and not is_home and not found["no"]):
        return PersonState(_household(), is_home)
    if who.removeprefix("not ") in _SOMEBODY | _NOBODY | _EVERYBODY:
        raise UsageError(f"{text!r}: of all people only 'somebody is home' and 'nobody is home' can be asked; name one")
    return PersonState(_person(found["who"]), is_home)


def read_move(text: str) -> PersonState | None:
    """Return the beginning state of *text*: ``Anna arrives``, ``everybody has left``; None for no move.

    Raises:
        UsageError: It is the move of one of several, which is not known.
    """
    found = _MOVES.fullmatch(text)
    if found is None or fold(found["who"]) in _ROBOT:
        return None
    who, comes = fold(found["who"]), bool(found["comes"])
    if (who in _SOMEBODY and comes) or (who in _EVERYBODY and not comes):
        return PersonState(_household(), comes)
    if who in _SOMEBODY | _NOBODY | _EVERYBODY:
        raise UsageError(f"{text!r}: write 'everybody has left', 'somebody arrives', or name a person")
    return PersonState(_person(found["who"]), comes)


def check_known(text: str, query: Query) -> None:
    """Check that *query* matches no person while nothing is known of them.

    Raises:
        UsageError: It does.
    """
    match query:
        case Not(term) if any(isinstance(one, StateIs) and one.capability == AT_HOME for one in leaves(term)):
            raise UsageError(f"{text!r} would hold as well while it is unknown; write it like 'Anna is away'")
        case And(terms) | Or(terms):
            for one in terms:
                check_known(text, one)


def may_begin(query: Query) -> bool:
    """Return whether a state that was unknown before may start something: that people are away, never a return."""
    return all(one.value is False for one in leaves(query) if isinstance(one, StateIs) and one.capability == AT_HOME)


def _household() -> Query:
    return TypeIs("household", frozenset({"x_household"}), by_word=False)


def _person(name: str) -> Query:
    return And((TypeIs("person", frozenset({"x_person"}), by_word=False), NameIs(fold(name))))
