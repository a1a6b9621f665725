"""Any text as a query or goal: it is understood, or a UsageError says what of it is not."""

from contextlib import suppress
from time import process_time

from tests.fuzz.conftest import Fuzz
from tests.turns import slowness

from homebot.devices.capabilities import CAPABILITIES
from homebot.discovery import DeviceIndex
from homebot.errors import UsageError
from homebot.words.queries import parse_query
from homebot.words.tokens import quoted
from homebot.words.wishes import KnownNames, read_wishes

WORDS = """\
on off lights lamp in kitchen and or not ( ) type area = : < >= 50 % " ' fresh stale reachable level temperature
°C locked doors near name id , - 1e999 ü capability category config"""
GOALS = "rosie is are lit dark docked scene film at set to the no , and 40 % house"
GOAL_WORDS = (*WORDS.split(), *GOALS.split())
PIECES = (*WORDS.split(), "brighter than", "\ud800", *sorted(CAPABILITIES)[:20])


def test_any_text_is_a_query_or_refused(fuzz: Fuzz) -> None:
    index = DeviceIndex(forget_after=1.0)

    for mutate, rng in fuzz("queries", PIECES):
        text = rng.choice((" ", "")).join(mutate.word() for _ in range(rng.randrange(1, 12)))
        if rng.random() < 0.3:
            text = mutate.damaged_text(text)
        with suppress(UsageError):
            assert not index.find(parse_query(text))
        index.find(parse_query(f"name={quoted(text[:200])}"))


def test_any_text_is_a_goal_or_refused_at_once(fuzz: Fuzz) -> None:
    known = KnownNames(("Kitchen", "Hall"), ("Kitchen", "Hall", "house"), ("rosie",), ("Film",))
    limit = 0.1 * slowness()
    for mutate, rng in fuzz("goals", GOAL_WORDS):
        text = rng.choice((" ", "", "\n")).join(mutate.word() * rng.choice((1, 1, 30)) for _ in range(8))[:1000]
        begun = process_time()
        with suppress(UsageError):
            read_wishes(text, known)
        assert process_time() - begun < limit, text
