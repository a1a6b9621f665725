"""What ``homebot why``, ``why-not`` and ``journal`` print, letter by letter; see test_golden.py."""

import re
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.cli.golden.conftest import Run, StillHouse, ago, kitchen_lamp
from tests.cli.golden.test_golden import check

from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.journal_messages import JournalEntry, JournalFact, JournalVerdict
from homebot.devices.outcomes import (
    AlreadySo,
    Confirmed,
    Contradicted,
    Evidence,
    Gone,
    NoAnswer,
    Outcome,
    Refused,
    Reverted,
    Superseded,
)
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue, Reading, Value

Text = pytest.CaptureFixture[str]

LAMP = "kitchen-lamp"


@pytest.fixture(autouse=True)
def _utc(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


def entry(**fields: object) -> JournalEntry:
    return JournalEntry.model_validate(fields)


def settings(**values: PlainValue) -> tuple[Setting, ...]:
    return tuple(Setting(capability=name, value=Value.of(value)) for name, value in values.items())


def motion(seconds: float) -> Trigger:
    reading = Reading(part="", capability="occupancy", value=Value.of(True))
    return Trigger(kind="report", id="report-7", device="motion/kitchen", readings=(reading,), at=ago(seconds))


def command(
    name: str,
    seconds: float,
    outcome: Outcome,
    *,
    issuer: str = "/follow_me",
    trigger: Trigger = NO_TRIGGER,
    verdicts: tuple[JournalVerdict, ...] = (),
    tries: int = 1,
    reports: tuple[float, ...] = (),
    **wanted: PlainValue,
) -> Iterator[JournalEntry]:
    """Yield the entries of a command that was given so many *seconds* ago."""
    of = {"device": LAMP, "part": "light", "command": name, "issuer": issuer}
    yield entry(kind="requested", at=ago(seconds), trigger=trigger, settings=settings(**wanted), **of)
    for verdict in verdicts:
        yield entry(kind="judged", at=ago(seconds), verdicts=(verdict,), **of)
    for number in range(tries):
        at = ago(seconds - 3.0 * number)
        yield entry(kind="sent", at=at, text="again" if number else "", **of)
        yield entry(kind="acknowledged", at=at, **of)
    for later in reports:
        yield entry(kind="reported", at=ago(seconds - later), settings=settings(**wanted), **of)
    decided: CommandResult = CommandResult.of(outcome)
    at = ago(seconds - max(reports, default=3.0 * tries if tries else 0.0))
    yield entry(kind="outcome", at=at, results=(decided,), **of)


def answered(name: str, seconds: float, **values: PlainValue) -> JournalEntry:
    """The report by which a device changed, in answer to a command that failed."""
    of = {"device": LAMP, "part": "light", "command": name, "issuer": "/follow_me"}
    return entry(kind="reported", at=ago(seconds), settings=settings(**values), cause="command", **of)


def changed(seconds: float, **values: PlainValue) -> JournalEntry:
    return entry(kind="changed", at=ago(seconds), device=LAMP, part="light", settings=settings(**values))


def gone_back(seconds: float, name: str, result: CommandResult, **values: PlainValue) -> JournalEntry:
    back, results = settings(**values), (result,)
    return entry(
        kind="reverted",
        at=ago(seconds),
        device=LAMP,
        part="light",
        command=name,
        settings=back,
        results=results,
        cause="unknown",
    )


def published(name: str, seconds: float, text: str, **reported: PlainValue) -> Iterator[JournalEntry]:
    of = {"device": LAMP, "command": name}
    yield entry(kind="published", at=ago(seconds), text=text, issuer="/light_service", **of)
    yield entry(kind="reported", at=ago(seconds - 0.2), settings=settings(**reported), **of)


ALLOWED = JournalVerdict(
    policy="presence_guard",
    allowed=True,
    reason="somebody is in the kitchen",
    facts=(JournalFact(name="occupancy of motion/kitchen", value=Value.of(True), since=ago(45)),),
)
REFUSED = JournalVerdict(policy="presence_guard", allowed=False, reason="somebody is in the kitchen")

BY_LEASE = JournalVerdict(policy="lease", allowed=False, reason="held open by robot for 9 s more")


def denied(
    seconds: float, wanted: str, count: float, *, device: str = LAMP, target: str = "/gateway/mqtt/out"
) -> JournalEntry:
    """A client without the right that published."""
    facts: dict[str, PlainValue] = {
        "operation": "publish",
        "target": target,
        "right": "raw",
        "address": "127.0.0.1:4",
        "count": count,
    }
    verdict = JournalVerdict(
        policy="rights",
        allowed=False,
        reason='the right raw is missing; the token tv has: read. To give it, write scope = ["raw"] …',
        facts=tuple(JournalFact(name=name, value=Value.of(value)) for name, value in facts.items()),
    )
    return entry(kind="denied", at=ago(seconds), device=device, issuer="client:tv", text=wanted, verdicts=(verdict,))


def lease(
    kind: str, seconds: float, text: str, *, issuer: str = "client:robot", verdicts: tuple[JournalVerdict, ...] = ()
) -> JournalEntry:
    held = settings(movement="open")
    return entry(kind=kind, at=ago(seconds), device=LAMP, issuer=issuer, text=text, settings=held, verdicts=verdicts)


CONFIRMED = Confirmed(0.4, Evidence.REPORTED)


def story(name: str) -> list[JournalEntry]:
    """What the journal has in each of the cases."""
    app = [
        *command("a-1", 40.4, CONFIRMED, trigger=motion(40.5), verdicts=(ALLOWED,), reports=(0.4,), on_off=True),
    ]
    match name:
        case "app":
            return app
        case "level":
            return [*command("a-1", 40.4, CONFIRMED, issuer="client:tablet", reports=(0.4,), level=40.0)]
        case "retried":
            return [*command("a-1", 46.4, Confirmed(6.4, Evidence.REPORTED), tries=3, reports=(6.4,), on_off=True)]
        case "client":
            return [*command("a-1", 40.4, CONFIRMED, issuer="client:tablet", reports=(0.4,), on_off=True, level=40.0)]
        case "hand":
            return [*command("a-1", 4000, CONFIRMED, reports=(0.4,), on_off=False), changed(40, on_off=True)]
        case "reverted":
            reverted = CommandResult.of(Reverted(6.0))
            return [*app, gone_back(34, "a-1", reverted, on_off=False)]
        case "raw":
            return [*published("a-1", 40.2, "on", on_off=True)]
        case "refused":
            return [
                *command("a-1", 900, NoAnswer(9.0), tries=3, on_off=False),
                *command("a-2", 600, AlreadySo(), tries=0, on_off=True, issuer="client:tablet"),
                *command(
                    "a-3",
                    30,
                    Refused("presence_guard", "somebody is in the kitchen"),
                    verdicts=(REFUSED,),
                    tries=0,
                    trigger=Trigger(kind="timer", id="timer-60", text="every 60 s"),
                    issuer="/lights_out",
                    on_off=False,
                ),
            ]
        case "denied":
            return [denied(50, "unlock", 3.0), denied(45, "", 1.0, device="", target="/gateway/mqtt/readings")]
        case "lease":
            return [
                lease("held", 60, "robot"),
                lease("denied", 50, "guard", verdicts=(BY_LEASE,), issuer="client:tablet"),
                lease("outranked", 40, "movement is closed", issuer=""),
                lease("handed_back", 30, "", issuer=""),
                lease("released", 20, "robot"),
                lease("held", 10, "vacuum", issuer="/cleaner"),
                lease("held", 8, "robot"),
                lease("ended", 7, "robot", issuer="client:owner"),
                lease("expired", 5, "vacuum", issuer="/cleaner"),
            ]
    return outcomes(name)


def outcomes(name: str) -> list[JournalEntry]:
    """What it has where commands came to nothing."""
    match name:
        case "outcomes":
            asked = (
                (NoAnswer(9.0), 3),
                (Contradicted("on_off: on"), 1),
                (Superseded("a-9"), 1),
                (Refused("lease", "held on by robot for 8 s more"), 0),
                (Refused("rights", "client:tv may not command kitchen-lamp: the client has read"), 0),
                (Gone(), 0),
                (NoAnswer(0.0, "the gateway mqtt has no connection"), 1),
                (CONFIRMED, 1),
            )
            commands = [
                [*command(f"a-{number}", 900 - 60 * number, one, tries=tries, on_off=False)]
                for number, (one, tries) in enumerate(asked)
            ]
            reverted = CommandResult.of(Reverted(6.0))
            back = gone_back(34, "a-7", reverted, on_off=True)
            return [*(one for entries in commands for one in entries), back]
        case "superseded":
            return [
                *command("a-1", 50, Superseded("a-2"), issuer="/lights_out", tries=2, on_off=False),
                *command("a-2", 40.4, CONFIRMED, issuer="client:tablet", reports=(0.4,), on_off=True),
            ]
        case "contradicted":
            return [*command("a-1", 50, Contradicted("on_off: on"), tries=1, on_off=False), changed(40, on_off=True)]
        case "witness":
            witnessed = Contradicted("Kitchen lux measured no change", "Kitchen lux")
            return [*command("a-1", 40.4, witnessed, issuer="client:tablet", reports=(0.4,), on_off=True)]
        case "late":
            return [*command("a-1", 55, NoAnswer(9.0), tries=3, on_off=True), answered("a-1", 40, on_off=True)]
        case "later":
            return [*command("a-1", 90, NoAnswer(9.0), tries=3, on_off=True), answered("a-1", 40, on_off=True)]
        case "too_late":
            return [*command("a-1", 120, NoAnswer(9.0), tries=3, on_off=True), changed(40, on_off=True)]
        case "since":
            hall = [*command("a-1", 55, NoAnswer(9.0), tries=3, on_off=True)]
            refused = command("a-2", 43, Refused("lease", "held"), tries=0, on_off=False)
            return [*hall, *refused, answered("a-1", 40, on_off=True)]
        case "rounded":
            *steps, outcome = command("a-1", 40.4, Contradicted("level is 39.76"), tries=1, level=45.0)
            of = {"device": LAMP, "part": "light", "command": "a-1"}
            told = entry(kind="reported", at=ago(40), settings=settings(level=39.76), cause="unknown", **of)
            return [*steps, told, outcome]
        case "silent":
            return [
                *command("a-1", 300, CONFIRMED, reports=(0.4,), on_off=True),
                *command("a-2", 40, NoAnswer(9.0), tries=3, on_off=False),
            ]
    return []


def before_a_restart(name: str) -> list[JournalEntry]:
    """What it has where homebot was started since."""
    match name:
        case "on":
            return [*command("a-1", 4000, CONFIRMED, issuer="client:tablet", reports=(0.4,), on_off=True)]
        case "reverted":
            reverted = CommandResult.of(Reverted(10.0))
            back = gone_back(3990, "a-1", reverted, on_off=True)
            return [*command("a-1", 4000, CONFIRMED, reports=(0.4,), on_off=False), back]
        case "off":
            return [*command("a-1", 4000, CONFIRMED, reports=(0.4,), on_off=False)]
    return []


@pytest.mark.parametrize(
    ("name", "case", "arguments"),
    [
        ("why_app", "app", ["why", "Kitchen lamp"]),
        ("why_retried", "retried", ["why", "Kitchen lamp"]),
        ("why_client", "client", ["why", "Kitchen lamp"]),
        ("why_hand", "hand", ["why", "Kitchen lamp"]),
        ("why_reverted", "reverted", ["why", "Kitchen lamp"]),
        ("why_raw", "raw", ["why", "kitchen-lamp"]),
        ("why_unknown", "", ["why", "Kitchen lamp"]),
        ("why_silent", "", ["why", "windows/bath"]),
        ("why_json", "app", ["why", "Kitchen lamp", "--json"]),
        ("why_not_refused", "refused", ["why-not", "Kitchen lamp", "off"]),
        ("why_not_already", "refused", ["why-not", "Kitchen lamp", "on"]),
        ("why_not_nobody", "app", ["why-not", "Kitchen lamp", "off"]),
        ("why_not_empty", "", ["why-not", "Kitchen lamp", "off"]),
        ("why_not_so_unasked", "", ["why-not", "Kitchen lamp", "on"]),
        ("why_not_changed_since", "hand", ["why-not", "Kitchen lamp", "off"]),
        ("why_not_unknown", "refused", ["why-not", "Kitchen lamp", "lit"]),
        ("why_not_silent", "", ["why-not", "windows/bath", "open"]),
        ("why_not_json", "refused", ["why-not", "Kitchen lamp", "off", "--json"]),
        ("why_superseded", "superseded", ["why", "Kitchen lamp"]),
        ("why_contradicted", "contradicted", ["why", "Kitchen lamp"]),
        ("why_witness", "witness", ["why", "Kitchen lamp"]),
        ("why_no_answer", "silent", ["why", "Kitchen lamp"]),
        ("why_refused", "refused", ["why", "Kitchen lamp"]),
        ("why_late", "late", ["why", "Kitchen lamp"]),
        ("why_late", "since", ["why", "Kitchen lamp"]),
        ("why_late_json", "late", ["why", "Kitchen lamp", "--json"]),
        ("why_later", "later", ["why", "Kitchen lamp"]),
        ("why_unknown", "too_late", ["why", "Kitchen lamp"]),
        ("why_rounded", "rounded", ["why", "Kitchen lamp"]),
        ("why_hand_json", "hand", ["why", "Kitchen lamp", "--json"]),
        ("why_unknown_json", "", ["why", "Kitchen lamp", "--json"]),
        ("why_not_outcomes", "outcomes", ["why-not", "Kitchen lamp", "off"]),
        ("why_not_superseded", "superseded", ["why-not", "Kitchen lamp", "off"]),
        ("why_not_nobody_json", "app", ["why-not", "Kitchen lamp", "off", "--json"]),
        ("why_not_denied_json", "denied", ["why-not", "Kitchen lamp", "unlocked", "--json"]),
        ("journal_outcomes", "outcomes", ["journal"]),
        ("why_not_denied", "denied", ["why-not", "Kitchen lamp", "unlocked"]),
        ("journal", "refused", ["journal"]),
        ("journal_denied", "denied", ["journal"]),
        ("journal_denied_json", "denied", ["journal", "--json", "--limit", "1"]),
        ("journal_lease", "lease", ["journal"]),
        ("journal_device", "hand", ["journal", "Kitchen lamp", "--since", "10m"]),
        ("journal_limited", "app", ["journal", "--limit", "2"]),
        ("journal_json", "raw", ["journal", "--json"]),
        ("journal_empty", "", ["journal"]),
    ],
)
def test_they_print_what_they_should(
    still: StillHouse, run: Run, capsys: Text, name: str, case: str, arguments: list[str]
) -> None:
    still.journal = story(case)
    assert run(*arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    check(name, out)


def test_why_with_a_state_names_the_command_for_it(run: Run, capsys: Text) -> None:
    assert run("why", "Kitchen lamp", "on") == 1
    assert "`homebot why-not 'Kitchen lamp' on`" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "case", "arguments"),
    [
        ("why_restarted", "on", ["why", "Kitchen lamp"]),
        ("why_restarted_json", "on", ["why", "Kitchen lamp", "--json"]),
        ("why_restarted_reverted", "reverted", ["why", "Kitchen lamp"]),
        ("why_restarted_otherwise", "off", ["why", "Kitchen lamp"]),
        ("why_restarted_unknown", "", ["why", "Kitchen lamp"]),
    ],
)
def test_after_a_restart_the_last_change_is_the_one_before_it(
    still: StillHouse, run: Run, capsys: Text, name: str, case: str, arguments: list[str]
) -> None:
    """What a broker retained says how the device is, and not since when."""
    still.journal, still.is_restarted = before_a_restart(case), True
    assert run(*arguments) == 0
    check(name, capsys.readouterr().out)


@pytest.mark.parametrize(("name", "tells"), [("why_first", True), ("why_no_change", False)])
def test_of_a_failed_command_it_is_told_how_the_device_was_found(
    still: StillHouse, run: Run, capsys: Text, monkeypatch: pytest.MonkeyPatch, name: str, *, tells: bool
) -> None:
    """What the device tells first of all is no change."""
    states = [one.model_copy(update={"is_first": True}) for one in kitchen_lamp().states if tells]
    lamp = kitchen_lamp().model_copy(update={"states": tuple(states)})
    monkeypatch.setattr("tests.cli.golden.conftest.kitchen_lamp", lambda: lamp)
    still.journal = [*command("a-1", 55, NoAnswer(9.0), tries=3, on_off=False)]
    assert run("why", "Kitchen lamp") == 0
    check(name, capsys.readouterr().out)


@pytest.mark.parametrize("state", ["on", "40", "40%", "40 %", "level 40", "level 40 %", "Level 40"])
def test_a_level_is_found_however_people_say_it(still: StillHouse, run: Run, capsys: Text, state: str) -> None:
    still.journal = story("level")
    assert run("why-not", "Kitchen lamp", state) == 0
    assert f"{state} was asked for once:" in capsys.readouterr().out


@pytest.mark.parametrize("state", ["off", "4", "50", "level 4", "position 40"])
def test_another_level_was_not_asked_for(still: StillHouse, run: Run, capsys: Text, state: str) -> None:
    still.journal = story("level")
    assert run("why-not", "Kitchen lamp", state) == 0
    assert f"Nobody asked for {state} since the journal began" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("seconds", "result"),
    [(5, "its outcome is not known yet"), (4000, "its outcome is not known: homebot stopped before it was")],
)
def test_of_a_command_that_was_cut_short_it_is_told_that_nobody_knows(
    still: StillHouse, run: Run, capsys: Text, seconds: float, result: str
) -> None:
    still.journal = [*command("a-1", seconds, CONFIRMED, on_off=True)][:-1]
    assert run("why-not", "Kitchen lamp", "on") == 0
    assert capsys.readouterr().out.rstrip().endswith(f"  follow_me  {result}")


def test_of_a_state_that_is_so_the_last_command_is_enough(still: StillHouse, run: Run, capsys: Text) -> None:
    """It listed ten confirmed ones."""
    still.journal = [*command("a-1", 90, CONFIRMED, on_off=True), *command("a-2", 60, CONFIRMED, on_off=True)]
    assert run("why-not", "Kitchen lamp", "on") == 0
    assert "… the last 1 of 2; all: homebot journal" in capsys.readouterr().out


def test_why_not_without_a_state_says_what_to_give(run: Run, capsys: Text) -> None:
    assert run("why-not", "Kitchen lamp", " ") == 1
    assert capsys.readouterr() == ("", "homebot: give the state that the device is not in, such as on, open or 40\n")


def test_a_time_before_1970_is_the_whole_journal(still: StillHouse, run: Run, capsys: Text) -> None:
    still.journal = story("client")
    assert run("journal", "--since", "99999d") == 0
    assert "Kitchen lamp" in capsys.readouterr().out


def test_of_a_device_with_two_relays_it_is_told_which_one(
    still: StillHouse, run: Run, capsys: Text, monkeypatch: pytest.MonkeyPatch
) -> None:
    lamp = kitchen_lamp()
    (light,) = [one for one in lamp.parts if one.id == "light"]
    backlight = light.model_copy(update={"id": "back", "part": light.part.model_copy(update={"name": "backlight"})})
    both = lamp.model_copy(update={"parts": (light, backlight)})
    monkeypatch.setattr("tests.cli.golden.conftest.kitchen_lamp", lambda: both)
    still.journal = story("client")
    assert run("why", "Kitchen lamp") == 0
    assert "the client tablet asked Kitchen lamp light for on, level 40 %" in capsys.readouterr().out
    assert run("why-not", "Kitchen lamp", "on") == 0
    assert "Kitchen lamp light: confirmed after 0.4 s (reported)" in capsys.readouterr().out
    assert run("journal") == 0
    assert "  Kitchen lamp light  a-1  Kitchen lamp light reported on, level 40 %" in capsys.readouterr().out


def test_the_chain_in_the_guide_has_these_words(still: StillHouse, run: Run, capsys: Text) -> None:
    """The times and the names are others."""
    cleared = Reading(part="", capability="occupancy", value=Value.of(False))
    trigger = Trigger(kind="report", id="report-7", device="motion/hall", readings=(cleared,), at=ago(630))
    nobody = JournalVerdict(policy="presence_guard", allowed=True, reason="nobody is in Hall")
    confirmed = Confirmed(0.2, Evidence.REPORTED)
    still.journal = [
        *command(
            "a-1",
            30.2,
            confirmed,
            issuer="/lights_out",
            trigger=trigger,
            verdicts=(nobody,),
            reports=(0.2,),
            on_off=False,
        )
    ]
    assert run("why", "Kitchen lamp") == 0
    printed = capsys.readouterr().out.replace("Kitchen lamp", "Hall lamp").replace("motion/hall", "Hall motion")
    guide = (Path(__file__).parents[3] / "docs" / "journal.md").read_text()
    _, shown = guide.partition("$ homebot why 'Hall lamp'\n")[2].split("$ homebot", 1)[0].split("\n", 1)
    assert _without_times(shown) == _without_times(printed.split("\n", 1)[1])


def _without_times(text: str) -> list[str]:
    return re.sub(r"\d+ (s|min) ago|\d\d:\d\d:\d\d(\.\d)?", "", text).strip().splitlines()
