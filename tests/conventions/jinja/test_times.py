"""Templates with times: there is no clock, and no time zone."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest

from homebot.conventions.jinja import TemplateError, compile_template


@pytest.mark.parametrize(
    "source",
    [
        "{{ now() }}",
        "{{ utcnow() }}",
        "{{ 0 | timestamp_custom('%Y') }}",
        "{{ as_datetime('2026-03-04T05:06:07') | as_local }}",
        "{{ as_timestamp('1970-01-01T02:00:00') }}",
    ],
)
def test_without_a_clock_local_time_fails(source: str) -> None:
    with pytest.raises(TemplateError, match="not available here"):
        compile_template(source).render_value("")


@pytest.mark.parametrize("name", ["timestamp_utc", "timestamp_local"])
def test_absolute_time_needs_no_clock(name: str) -> None:
    assert compile_template(f"{{{{ 0 | {name} }}}}").render({}) == datetime.fromtimestamp(0, UTC).isoformat()


@pytest.mark.parametrize("form", ["%1000000000d", "%-5d", "%Y" * 40, "%"])
def test_a_format_of_times_has_plain_fields_only(form: str) -> None:
    with pytest.raises(TemplateError, match="plain fields"):
        compile_template("{{ 0 | timestamp_custom(form, false) }}").render({"form": form})


@pytest.mark.parametrize(
    ("source", "text"),
    [
        ("{{ strptime(value, '%d.%m.%Y %H:%M').isoformat() }}", "2026-03-04T05:06:00"),
        ("{{ as_timestamp(strptime(value ~ '+0200', '%d.%m.%Y %H:%M%z')) | int }}", "1772593560"),
        ("{{ (strptime(value, '%d.%m.%Y %H:%M') - timedelta(minutes=6)).hour }}", "5"),
        ("{{ strptime(value, '%Y', none) }}", "None"),
        ("{{ strptime(value, '%d%d', 'no time') }}", "no time"),
        ("{{ strptime(5, '%d', 'no time') }}", "no time"),
    ],
)
def test_a_time_is_read_by_its_format(source: str, text: str) -> None:
    assert compile_template(source).render_value("04.03.2026 05:06") == text


@pytest.mark.parametrize("value", ["soon", "1" * 300])
def test_a_time_in_another_format_fails_without_default(value: str) -> None:
    with pytest.raises(TemplateError, match="strptime"):
        compile_template("{{ strptime(value, '%d') }}").render_value(value)
