from homebot.testing import house_of


async def test_the_lamp_goes_on_when_the_window_opens() -> None:
    async with house_of("window_light:WindowLight") as house:
        await house.says("home425/lights/lamp/out", "off")
        await house.says("home425/windows/kitchen/out", "open")
        assert await house.hears("home425/lights/lamp/in") == "on"
