import pytest


@pytest.mark.homebot("thesis_light_service:ThesisLightService")
async def test_it_answers_each_on_with_off(homebot):
    for _ in range(3):
        await homebot.says("home425/lights/lamp/out", "on")
        assert await homebot.hears("home425/lights/lamp/in") == "off"
