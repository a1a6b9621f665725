"""Which commands are the same, which are added, and which are gone."""

from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.value import Value
from homebot.features.recording.command_diff import command_diff
from homebot.recording.lines import RecordedCommand
from homebot.recording.recording import TimedCommand

ISSUERS = ("/app",)
REFUSED = CommandResult(
    command_id="1", outcome="refused", text="refused", policy="presence_guard", reason="somebody is in the hall"
)
LINK = CommandResult(command_id="1", outcome="refused", text="refused", policy="gateway", reason="it only observes")


def given(at: float, *, value: bool = False, issuer: str = "/app", result: CommandResult | None = None) -> TimedCommand:
    settings = (Setting(capability="on_off", value=Value.of(value)),)
    return TimedCommand(at, RecordedCommand(id="1", issuer=issuer, device="lamp", settings=settings), result)


def pressed(at: float) -> TimedCommand:
    settings = (Setting(capability="push", value=Value.of(True)),)
    return TimedCommand(at, RecordedCommand(id="1", issuer="/app", device="bell", settings=settings))


def kinds(
    recorded: list[TimedCommand], replayed: list[TimedCommand], ends_at: float = 1000.0
) -> list[tuple[str, float]]:
    return [(one.kind, one.given.at) for one in command_diff(recorded, replayed, ISSUERS, ends_at).different]


def test_the_same_command_may_be_a_second_earlier_or_later() -> None:
    assert kinds([given(10), given(20)], [given(11), given(19)]) == []
    assert kinds([given(10)], [given(11.01)]) == [("gone", 10), ("added", 11.01)]


def test_each_command_has_one_counterpart() -> None:
    assert kinds([given(10)], [given(9.4), given(10.6)]) == [("added", 10.6)]
    assert kinds([given(10), given(11.5)], [given(10.6)]) == [("gone", 11.5)]


def test_what_an_app_says_again_within_a_second_counts_once() -> None:
    """A lamp may report the same three times, while a busy computer still acts upon the first."""
    assert kinds([given(10)], [given(10), given(10.01), given(10.02)]) == []
    assert kinds([given(10), given(10.5)], [given(10.2)]) == []
    assert command_diff([given(10), given(10.5)], [given(10)], ISSUERS, 1000.0).same == 1


def test_a_repeat_on_one_side_may_be_a_command_of_its_own_on_the_other() -> None:
    """The app commanded again 0.99 s later in the recording, and 1.01 s later in the replay; or the other way."""
    close, apart = [given(10), given(10.99)], [given(10), given(11.01)]
    assert kinds(close, apart) == []
    assert kinds(apart, close) == []


def test_what_is_taken_back_between_is_no_repeat() -> None:
    strobe = [given(10), given(10.2, value=True), given(10.4)]
    assert kinds([given(10)], strobe) == [("added", 10.2), ("added", 10.4)]


def test_a_button_is_pressed_as_often_as_an_app_says() -> None:
    assert kinds([pressed(10)], [pressed(10), pressed(10.5)]) == [("added", 10.5)]


def test_another_value_is_another_command() -> None:
    assert kinds([given(10)], [given(10, value=True)]) == [("added", 10), ("gone", 10)]


def test_other_issuers_are_not_compared() -> None:
    assert kinds([given(10, issuer="client:local")], [given(20, issuer="/other")]) == []


def test_a_command_that_a_policy_refused_was_not_carried_out() -> None:
    assert kinds([given(10, result=REFUSED)], [given(10, result=REFUSED)]) == []
    assert kinds([given(10, result=LINK)], [given(10)]) == []
    diff = command_diff([given(10)], [given(10, result=REFUSED)], ISSUERS, 1000.0)
    assert [(one.kind, one.refused) for one in diff.different] == [("gone", "presence_guard: somebody is in the hall")]
    diff = command_diff([given(10, result=REFUSED)], [given(10)], ISSUERS, 1000.0)
    assert [(one.kind, one.refused) for one in diff.different] == [("added", "presence_guard: somebody is in the hall")]


def test_what_is_given_in_the_last_second_may_have_its_counterpart_after_the_end() -> None:
    assert kinds([given(99.5)], [], ends_at=100.0) == []
    assert kinds([given(98.5)], [], ends_at=100.0) == [("gone", 98.5)]


def test_the_same_commands_are_counted() -> None:
    diff = command_diff([given(10), given(20), given(30)], [given(10), given(20)], ISSUERS, 1000.0)
    assert diff.same == 2
