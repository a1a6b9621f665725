"""What a look tells about its own error."""

import pytest

from homebot.identify.sight import Looker


class Steady:
    """A sensor that always tells the same."""

    def __init__(self, slack: float) -> None:
        self.slack = slack

    async def values(self) -> list[float]:
        return [100.0]


@pytest.mark.parametrize(("slack", "deviation"), [(0.0, 0.1), (0.25, 25.0)])
async def test_what_a_sensor_leaves_unreported_is_an_error_of_the_look(slack: float, deviation: float) -> None:
    """A sensor that reports changes of a fifth said nothing as the lamp went out, and none was sure to be in view."""
    look = await Looker(Steady(slack), lambda: 0.0).look()
    assert (look.value, look.variance**0.5) == (100.0, pytest.approx(deviation, rel=1e-3))
