"""What the words of a device look like in the thesis's layout."""

from homebot.house.dialect import DeviceState, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.kinds import KINDS
from homebot.integrations.thesis.simulated import ThesisDialect

LAMP = SimulatedDeviceInfo("villa", "lamp", "desk", "lights", "study")


def test_the_thesis_says_words_as_they_are_and_announces_nothing() -> None:
    """On the device's own topics."""
    thesis = ThesisDialect()
    assert thesis.filters(LAMP) == ("villa/lights/desk/in",)
    assert thesis.state_messages(LAMP, DeviceState(text="21.5")) == (
        OutgoingMessage("villa/lights/desk/out", b"21.5", retain=False, qos=1),
    )
    assert thesis.state_messages(LAMP, DeviceState(text="\ud800")) == (OutgoingMessage("villa/lights/desk/out", b"?"),)
    assert (thesis.birth(LAMP), thesis.will(LAMP)) == ((), None)
    assert thesis.kinds == KINDS.keys()


def test_the_thesis_takes_any_payload_for_a_word() -> None:
    """What it means is for the device."""
    told = ThesisDialect().parse_command
    assert told(LAMP, "villa/lights/desk/in", b"on") == ("on",)
    assert told(LAMP, "villa/lights/desk/in", b"\xff") == ("�",)
