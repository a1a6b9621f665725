"""Queries without guessing, for permissions and bans of the owner: a misspelt word would match nothing. Pure."""

from homebot.devices.query.terms import HasText, Query, leaves, split_near
from homebot.errors import UsageError
from homebot.support.folding import is_typo
from homebot.words.queries import parse_in_any_house, parse_query
from homebot.words.vocabulary import CAPABILITY_WORDS, TYPE_WORDS


def parse_exact_query(text: str) -> Query:
    """Parse *text* as a query of types, capabilities, rooms and other fields.

    Raises:
        UsageError: It is not a query, or has a word that would be searched for in all texts of devices; names the word.
    """
    query = parse_lasting_query(text)
    if word := next((one.text for one in leaves(query) if isinstance(one, HasText)), ""):
        meant = sorted(one for one in {*TYPE_WORDS, *CAPABILITY_WORDS} if is_typo(word, one))
        hint = (
            f"did you mean {' or '.join(meant)}?"
            if meant
            else 'searched words may fit anything; write name="…" or id="…" for one device'
        )
        raise UsageError(f"{word!r} is neither a type nor a capability; {hint}")
    return query


def parse_cautious_query(text: str) -> Query:
    """Parse *text* as a query for a ban: words that may be a name mean what is called so as well.

    Raises:
        UsageError: As for :func:`parse_lasting_query`.
    """
    parse_lasting_query(text)
    return parse_in_any_house(text)


def parse_lasting_query(text: str) -> Query:
    """Parse *text* as a query for a rule, which must not depend on the position of a robot.

    Raises:
        UsageError: It is not a query, or has a condition to be near a robot.
    """
    query = parse_query(text)
    if split_near(query)[0] is not None:
        raise UsageError("a rule cannot depend on the position of a robot; name a room instead")
    return query
