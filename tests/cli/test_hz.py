"""What `topic hz` makes of arrival times."""

from __future__ import annotations

from homebot.cli.commands.topic import rate_text


def test_a_steady_topic_has_no_deviation() -> None:
    assert rate_text([10.0, 10.5, 11.0]) == (
        "average rate: 2.000\n\tmin: 0.500s max: 0.500s std dev: 0.00000s window: 3"
    )


def test_messages_at_one_instant_have_an_infinite_rate() -> None:
    assert rate_text([1.0, 1.0]).startswith("average rate: inf\n")
