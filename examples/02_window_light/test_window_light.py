import pytest


@pytest.mark.homebot("window_light:WindowLight")
async def test_the_lamp_goes_on_when_the_window_opens(homebot):
    await homebot.says("home425/lights/lamp/out", "off")
    await homebot.says("home425/windows/kitchen/out", "open")
    assert await homebot.hears("home425/lights/lamp/in") == "on"
