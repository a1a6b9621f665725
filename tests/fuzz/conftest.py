"""Seeded fuzzing: ``make test`` tries 250 generated cases of each target, ``make fuzz`` 100,000.

A case is made from the seed, its target and its number alone, so ``make fuzz SEED=…`` repeats a failure. Those that
failed in ``make fuzz`` are kept in ``crashes.txt``, and tried in each run. Only what a function's contract names may
come out of a case.
"""

import json
import math
import os
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from homebot.conventions.convention import Convention
from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

SEED = int(os.environ.get("FUZZ_SEED", "1"))
CASES = int(os.environ.get("FUZZ_CASES", "250"))
CRASHES = Path(__file__).with_name("crashes.txt")
PARTS = 4
KINDS = {"bool": bool, "number": float, "text": str, "numbers": tuple}
WORDS = (*"on off ON None null a/b # + $x".split(), "", "{{ value }}", "\x00", "\ud800", "ü" * 40, "9" * 400)  # noqa: SIM905
NUMBERS = (0, 1, -1, 2**31, 10**40, -(10**400), 0.5, 1e308, -0.0, math.nan, math.inf, True, 255, 65_536)
TOPICS = ("homeassistant/x", "zigbee2mqtt/bridge/devices", "homie/5/d/$state", "shellies/announce", "a/../b", "+/#")


class Mutator:
    """Generated and damaged values, by one source of chance.

    Args:
        rng: The source.
        words: Texts that may mean something to the target.
    """

    def __init__(self, rng: random.Random, words: Sequence[str] = ()) -> None:
        self.rng = rng
        self._words = (*words, *WORDS)

    def word(self) -> str:
        return self.rng.choice(self._words)

    def scalar(self) -> object:
        return self.rng.choice((self.word(), self.word(), self.rng.choice(NUMBERS), None, self.rng.random() < 0.5))

    def value(self, depth: int = 3) -> object:
        """A JSON value."""
        kind = self.rng.randrange(6) if depth else 0
        if kind < 4:
            return self.scalar()
        count = self.rng.randrange(4)
        if kind == 4:
            return [self.value(depth - 1) for _ in range(count)]
        return {self.word(): self.value(depth - 1) for _ in range(count)}

    def plain(self) -> PlainValue:
        """A value as an app may tell it."""
        number = float(self.rng.choice((0, 1, 50, 100, 300, -1, math.nan, math.inf, 1e300)))
        numbers = tuple(float(self.rng.choice((0, 10, 360, -1, math.nan))) for _ in range(self.rng.randrange(4)))
        return self.rng.choice((None, True, False, number, number, self.word(), numbers))

    def damaged(self, value: object) -> object:
        """A JSON value in which one place is another."""
        if self.rng.random() < 0.3 or not isinstance(value, dict | list) or not value:
            return self.value()
        if isinstance(value, list):
            index = self.rng.randrange(len(value))
            changed = self.damaged(value[index])
            return [*value[:index], *([changed] * self.rng.choice((0, 1, 1, 2))), *value[index + 1 :]]
        key = self.rng.choice(list(value))
        rest = {one: other for one, other in value.items() if one != key}
        return {**rest, self.rng.choice((key, key, key, self.word())): self.damaged(value[key])}

    def damaged_json(self, text: str) -> bytes:
        """The JSON *text*, changed as values, or as bytes."""
        if self.rng.random() < 0.5:
            return self.damaged_bytes(text.encode())
        try:
            value = json.loads(text)
        except ValueError:
            return self.damaged_bytes(text.encode())
        for _ in range(self.rng.choice((1, 1, 2, 4))):
            value = self.damaged(value)
        return json.dumps(value).encode()

    def damaged_bytes(self, raw: bytes) -> bytes:
        """*raw* with a few bytes changed, taken out, put in or repeated."""
        data = bytearray(raw)
        for _ in range(self.rng.choice((1, 1, 2, 5))):
            where = self.rng.randrange(len(data) + 1)
            match self.rng.randrange(5):
                case 0:
                    data[where:where] = self.rng.randbytes(self.rng.choice((1, 4)))
                case 1:
                    del data[where : where + self.rng.choice((1, 1, 20))]
                case 2 if where < len(data):
                    flipped = data[where] ^ 1 << self.rng.randrange(8)
                    data[where] = self.rng.choice((0, 0x22, 0x2C, 0x5C, 0x7B, 0x7F, 0x80, 0xC3, 0xFF, flipped))
                case 3:
                    del data[where:]
                case _:
                    data[where:where] = data[: self.rng.randrange(30)]
        return bytes(data[:100_000])

    def damaged_text(self, text: str) -> str:
        return self.damaged_bytes(text.encode(errors="surrogatepass")).decode(errors="replace")


Fuzz = Callable[..., Iterator[tuple[Mutator, random.Random]]]
"""Makes the cases of one part of a test, from the name of its target and words that may mean something to it."""


@pytest.fixture(params=range(PARTS))
def fuzz(request: pytest.FixtureRequest) -> Iterator[Fuzz]:
    """The cases of one part of a test; where one fails, an error beside it tells how to repeat it, and it is kept."""
    running = ""

    def cases(target: str, words: Sequence[str] = ()) -> Iterator[tuple[Mutator, random.Random]]:
        nonlocal running
        kept = [] if request.param else crashes_of(target)
        for running in (*kept, *(f"{SEED}/{target}/{number}" for number in range(request.param, CASES, PARTS))):
            rng = random.Random(running)  # noqa: S311 - nobody guesses at it
            yield Mutator(rng, words), rng
        running = ""

    yield cases
    if running:
        if "FUZZ_CASES" in os.environ:
            with CRASHES.open("a") as file:
                file.write(f"{running}\n")
        pytest.fail("seed {}, target {}, case {}".format(*running.split("/")), pytrace=False)


def crashes_of(target: str) -> list[str]:
    """Return the kept cases of *target*: seed, target and number."""
    return [line for line in CRASHES.read_text().splitlines() if line.split("/")[1:2] == [target]]


def fuzz_convention(fuzz: Fuzz, name: str, make: Callable[[], Convention], rows: Sequence[Mapping[str, Any]]) -> None:
    """Let *make*'s convention hear damaged announcements and messages of *rows*, and tell what it described."""
    words = tuple(sorted({word for row in rows for _, text in row["messages"] for word in words_of(text)}))
    for mutator, rng in fuzz(name, words):
        convention = make()
        described: dict[str, DeviceAnnounced] = {}
        for topic, payload in announcements(mutator, rows):
            with suppress(WireError):
                heard = convention.read_message(topic, payload, retained=rng.random() < 0.7)
                described |= {one.key: one for one in heard if isinstance(one, DeviceAnnounced)}
        says = rng.choice(rows)["says"]
        for one in described.values():
            for part in one.parts[:4]:
                check_part(mutator, part, [said[1] for said in says])


def words_of(text: str) -> Iterator[str]:
    """The keys and short texts of a JSON text."""
    try:
        todo: list[object] = [json.loads(text)]
    except ValueError:
        return
    while todo:
        value = todo.pop()
        if isinstance(value, dict):
            yield from value
            todo += value.values()
        elif isinstance(value, list):
            todo += value
        elif isinstance(value, str) and len(value) < 40:
            yield value


def announcements(mutator: Mutator, rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, bytes]]:
    """The messages of one or two devices, some of them damaged, left out, repeated or in another order."""
    rng = mutator.rng
    messages = [message for row in rng.sample(rows, rng.choice((1, 1, 2))) for message in row["messages"]]
    if rng.random() < 0.2:
        rng.shuffle(messages)
    found: list[tuple[str, bytes]] = []
    damage = rng.choice((0.0, 0.1, 0.5))
    chosen = rng.randrange(len(messages))
    for number, (topic, text) in enumerate(messages):
        is_damaged = number == chosen or rng.random() < damage
        payload = mutator.damaged_json(text) if is_damaged else text.encode()
        if rng.random() < 0.02:
            topic = rng.choice(TOPICS)  # noqa: PLW2901 - another topic
        found += [(topic, payload)] * rng.choice((1, 1, 1, 1, 0, 2))
    return found


def check_part(mutator: Mutator, part: DescribedPart, spoken: Iterable[str]) -> None:
    """What it reads is of its capabilities and finite; what it is told is published or refused."""
    rng = mutator.rng
    names = {one.name for one in part.part.capabilities}
    payloads = [mutator.damaged_json(text) for text in [*spoken][:2]] + [mutator.word().encode(errors="replace")]
    for topic in part.codec.topics()[:3]:
        for payload in payloads:
            read = part.codec.read(topic.replace("+", "x").replace("#", "x"), payload, retained=rng.random() < 0.5)
            for name, value in read.items():
                assert name in names, (name, names)
                check_value(name, value)
    for one in part.part.capabilities[:4]:
        try:
            told = part.codec.write(one.name, mutator.plain(), transition=rng.choice((0.0, 1.5)))
        except RefusedError:
            continue
        assert all(not set(publication.topic) & set("+#\x00") for publication in told)
        assert {publication.topic for publication in told} <= set(part.part.writes)


def check_value(capability: str, value: PlainValue) -> None:
    assert value is None or type(value) is KINDS[CAPABILITIES[capability].kind], (capability, value)
    assert not isinstance(value, float) or math.isfinite(value), (capability, value)
