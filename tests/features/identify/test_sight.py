"""What a look tells about its own error."""

import pytest

from homebot.features.identify.sight import Noise, Sight


class Steady(Sight):
    """A sensor that always tells the same."""

    def __init__(self, slack: float) -> None:
        super().__init__()
        self.slack = slack

    async def values(self) -> list[float]:
        return [100.0]


@pytest.mark.parametrize(("slack", "deviation"), [(0.0, 0.1), (0.25, 25.0)])
async def test_what_a_sensor_leaves_unreported_is_an_error_of_the_look(slack: float, deviation: float) -> None:
    """A sensor that reports changes of a fifth said nothing as the lamp went out, and none was sure to be in view."""
    value, variance = await Steady(slack).look()
    assert (value, variance**0.5) == (100.0, pytest.approx(deviation, rel=1e-3))


def test_a_look_with_a_flash_counts_less_and_the_others_as_usual() -> None:
    noise, steady = Noise(), [100.0, 101.0, 99.0, 100.5, 99.5]
    _, usual = noise.of(steady)
    mean, flashed = noise.of([*steady[:4], 5000.0])
    assert flashed > 10_000 * usual
    assert abs(mean - 1080) < 1
    assert noise.of(steady)[1] == pytest.approx(usual)
