import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from homebot.conventions.light_color import (
    CHANNELS,
    Channels,
    from_hue_saturation,
    kelvin_mired,
    mired_bounds,
    to_hue_saturation,
)

WHITE = (2_000, 6_535)
MODES = sorted(CHANNELS)


@given(st.sampled_from(MODES), st.floats(0, 360), st.floats(0, 100))
def test_a_colour_is_nearly_the_same_after_both_conversions(mode: str, hue: float, saturation: float) -> None:
    channels = from_hue_saturation(mode, hue, saturation, WHITE)
    assert len(channels) == len(CHANNELS[mode])
    back, strength = to_hue_saturation(mode, channels, WHITE)
    assert strength == pytest.approx(saturation, abs=12)
    if saturation > 30:
        assert abs((back - hue + 180) % 360 - 180) < 8


@example("xy", [0.0, 5e-324, 0.0, 0.0, 0.0])
@given(st.sampled_from(MODES), st.lists(st.floats(0, 1), min_size=5, max_size=5))
def test_any_channels_are_some_colour(mode: str, parts: list[float]) -> None:
    most = {"hs": (360, 100), "xy": (1, 1)}.get(mode, (255,) * len(CHANNELS[mode]))
    hue, saturation = to_hue_saturation(mode, tuple(a * b for a, b in zip(parts, most, strict=False)), WHITE)
    assert 0 <= hue <= 360
    assert 0 <= saturation <= 100


@pytest.mark.parametrize(("value", "converted"), [(370, 2702), (2700, 370), (153, 6535), (1, 1_000_000)])
def test_kelvin_and_mired_are_rounded_down(value: float, converted: int) -> None:
    assert kelvin_mired(value) == converted


@pytest.mark.parametrize(
    ("bounds", "kelvin"),
    [((250, 500), (1997.0, 4000.0)), ((250, 65_279), (1000.0, 4000.0)), ((1_500, 2_000), (1000.0, 1000.0))],
    ids=["usual", "Namron 1402768", "all below"],
)
def test_no_lamp_has_a_white_below_any_flame(bounds: tuple[int, int], kelvin: tuple[float, float]) -> None:
    assert mired_bounds(*bounds) == kelvin


@pytest.mark.parametrize(
    ("mode", "channels", "color"),
    [
        ("rgb", (10, 200, 30), (126.316, 95.0)),
        ("rgbw", (0, 0, 0, 255), (0.0, 0.0)),
        ("rgbww", (0, 0, 0, 0, 255), (30.622, 94.51)),
        ("rgbww", (10, 20, 30, 40, 50), (22.5, 16.0)),
        ("rgbww", (0, 0, 0, 0, 0), (0.0, 0.0)),
        ("xy", (0.5, 0), (306.588, 100.0)),
        ("xy", (0.3, 0.6), (91.915, 73.725)),
    ],
)
def test_every_spelling_is_read(mode: str, channels: Channels, color: Channels) -> None:
    assert to_hue_saturation(mode, channels, WHITE) == pytest.approx(color)
