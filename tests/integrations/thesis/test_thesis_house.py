"""The house of the thesis."""

from homebot.house import thesis_world


def test_it_has_two_lamps_one_on_and_a_window_motor() -> None:
    """The experiment of chapter 8."""
    devices = [placed.device for placed in thesis_world().devices.values()]
    assert [device.service_type for device in devices] == ["lights", "lights", "windows"]
    assert [device.state() for device in devices] == ["on", "off", "closed"]
