"""Any topics and words in the thesis's layout: refused in our words, or understood."""

from contextlib import suppress

from tests.fuzz.conftest import Fuzz, Mutator, check_value

from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Part
from homebot.devices.text.commands import decode_command, encode_command
from homebot.devices.text.states import decoder_for
from homebot.errors import RefusedError, WireError
from homebot.integrations.thesis.formats import Thesis, ThesisSettings

LEVELS = ("lights", "windows", "locks", "plugs", "fans", "thermostats", "out", "in", "", "home425", *DEVICE_TYPES)
SPOKEN = ("on", "off", "0.4", "2700 K", "open", "closed, 0 %", "21.5", "locked", "nan", "1e999", "-5", "300 50")


def test_any_topic_is_refused_or_a_device(fuzz: Fuzz) -> None:
    layouts = (Thesis(ThesisSettings(root="home425")), Thesis(ThesisSettings()))

    for mutate, rng in fuzz("thesis", LEVELS):
        levels = ["home425", rng.choice(LEVELS), mutate.word(), "out"]
        topic = "/".join(levels[: rng.choice((4, 4, 4, 2, 3))] + [mutate.word()] * rng.choice((0, 0, 0, 1, 2)))
        with suppress(WireError):
            announced = rng.choice(layouts).announced(topic)
            if announced is not None:
                check_words(mutate, announced.parts[0].part)


def check_words(mutate: Mutator, part: Part) -> None:
    """What is heard is of the part's capabilities; what is told has a word that means the same, or is refused."""
    known = {one.name for one in part.capabilities}
    for spoken in (mutate.rng.choice(SPOKEN), mutate.damaged_text(mutate.rng.choice(SPOKEN)), mutate.word()):
        for name, value in decoder_for(part.capabilities).decode(spoken.encode(errors="replace")).items():
            assert name in known
            check_value(name, value)
        with suppress(RefusedError):
            assert decode_command(spoken, part)[0] in known
    for one in part.capabilities:
        with suppress(RefusedError):
            decode_command(encode_command(one.name, mutate.plain(), part), part)
