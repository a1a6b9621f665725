"""Points in time as people write them."""

from datetime import UTC, datetime, timedelta, timezone

import pytest

from homebot.errors import UsageError
from homebot.testing.virtual_house import next_moment, parse_time

NOW = datetime(2026, 1, 1, 12, 0, 30, tzinfo=UTC)


@pytest.mark.parametrize(
    ("when", "expected"),
    [
        ("22:00", datetime(2026, 1, 1, 22, tzinfo=UTC)),
        ("7:05", datetime(2026, 1, 2, 7, 5, tzinfo=UTC)),
        ("12:00", datetime(2026, 1, 2, 12, tzinfo=UTC)),
        ("12:00:30", datetime(2026, 1, 2, 12, 0, 30, tzinfo=UTC)),
        ("12:00:31", datetime(2026, 1, 1, 12, 0, 31, tzinfo=UTC)),
        ("2026-01-03", datetime(2026, 1, 3, tzinfo=UTC)),
        ("2026-01-03 07:30", datetime(2026, 1, 3, 7, 30, tzinfo=UTC)),
        ("2026-01-03T07:30+01:00", datetime(2026, 1, 3, 6, 30, tzinfo=UTC)),
        (datetime(2026, 1, 3, 7, tzinfo=timezone(timedelta(hours=2))), datetime(2026, 1, 3, 5, tzinfo=UTC)),
    ],
)
def test_a_moment_is_the_next_that_fits(when: str | datetime, expected: datetime) -> None:
    assert next_moment(NOW, when) == expected


@pytest.mark.parametrize("when", ["", "24:00", "12:60", "noon", "8h", "2026-13-01"])
def test_what_is_no_moment_is_refused_with_an_example(when: str) -> None:
    with pytest.raises(UsageError, match="is not a time; write it like 22:00 or 2026-01-01 22:00"):
        next_moment(NOW, when)


def test_the_past_is_refused() -> None:
    with pytest.raises(UsageError, match="2025-12-31 00:00:00 is in the past"):
        next_moment(NOW, "2025-12-31")


def test_without_a_time_zone_it_is_utc() -> None:
    assert parse_time("2026-01-01 10:00").utcoffset() == timedelta(0)
