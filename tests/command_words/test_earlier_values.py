"""What was before commands comes back, except where something else has changed it since."""

from homebot.command_words.earlier_values import EarlierValues, KnownStates
from homebot.devices.command_messages import CommandedPart, CommandResult, Setting
from homebot.devices.device import State
from homebot.devices.outcomes import AlreadySo, Confirmed, Evidence, NoAnswer, Outcome, Refused
from homebot.devices.value import PlainValue, Value
from homebot.messages import Time

LAMP = ("lamp", "")


def lamp(since: float, **values: PlainValue) -> KnownStates:
    at = Time.from_seconds(since)
    return {
        ("lamp", "", name): State(part="", capability=name, value=Value.of(value), since=at, told_at=at, live=True)
        for name, value in values.items()
    }


def undone(before: KnownStates, now: KnownStates) -> dict[tuple[str, str], tuple[Setting, ...]]:
    """Undo a command that was given at 100 and ended at 101."""
    earlier = EarlierValues()
    earlier.add_parts(before, [LAMP], 100.0, 101.0)
    return earlier.due(now)


def test_a_value_that_the_command_brought_about_comes_back() -> None:
    was, now = lamp(1.0, on_off=True, level=20.0), lamp(100.5, on_off=True, level=80.0)
    assert undone(was, now) == {LAMP: (Setting.of("level", 20.0),)}


def test_a_lamp_that_was_off_is_only_turned_off() -> None:
    """Its level would turn it on again."""
    was, now = lamp(1.0, on_off=False, level=20.0), lamp(100.5, on_off=True, level=80.0)
    assert undone(was, now) == {LAMP: (Setting.of("on_off", False),)}


def test_what_a_person_changed_later_stays() -> None:
    assert undone(lamp(1.0, level=20.0), lamp(150.0, level=80.0)) == {}


def test_a_lamp_that_a_person_turned_off_meanwhile_stays_off() -> None:
    now = {**lamp(100.5, level=80.0), **lamp(150.0, on_off=False)}
    assert undone(lamp(1.0, on_off=True, level=20.0), now) == {}


def test_a_lock_stays_as_it_is() -> None:
    assert undone(lamp(1.0, lock="unlocked"), lamp(100.5, lock="locked")) == {}


def test_a_cover_goes_back_to_its_position_without_a_word_for_its_movement() -> None:
    was, now = lamp(1.0, position=30.0, movement="opening"), lamp(100.5, position=100.0, movement="open")
    assert undone(was, now) == {LAMP: (Setting.of("position", 30.0),)}


def test_a_second_command_keeps_what_was_before_the_first() -> None:
    earlier = EarlierValues()
    earlier.add_parts(lamp(1.0, level=20.0), [LAMP], 100.0, 101.0)
    earlier.add_parts(lamp(100.5, level=80.0), [LAMP], 200.0, 201.0)
    assert earlier.due(lamp(200.5, level=50.0)) == {LAMP: (Setting.of("level", 20.0),)}
    assert earlier.due(lamp(200.5, level=50.0)) == {}, "an undo is done once"


def test_it_can_be_kept_as_json() -> None:
    earlier = EarlierValues({"lamp color": [[120.0, 50.0], 100.0, 101.0]})
    assert earlier.due(lamp(100.5, color=(0.0, 100.0))) == {LAMP: (Setting.of("color", (120.0, 50.0)),)}


def commanded(outcome: Outcome) -> CommandedPart:
    return CommandedPart(device="lamp", name="Lamp", part="", result=CommandResult.of(outcome))


def undone_after(outcome: Outcome, now: KnownStates) -> list[tuple[str, str]]:
    """Undo a command that turned the lamp on, was given at 100 and ended at 101, with this outcome."""
    earlier = EarlierValues()
    earlier.add(lamp(1.0, on_off=False, level=20.0), [commanded(outcome)], 100.0, 101.0)
    return list(earlier.due(now))


def test_what_a_person_changed_a_moment_after_the_report_of_the_device_stays() -> None:
    confirmed = Confirmed(0.5, Evidence.REPORTED, reported={"level": 80.0})
    assert undone_after(confirmed, lamp(103.0, level=30.0)) == []
    assert undone_after(confirmed, lamp(103.0, level=80.5)) == [LAMP], "the last step of a dimmer"


def test_a_command_without_an_effect_has_nothing_to_bring_back() -> None:
    assert undone_after(AlreadySo(), lamp(103.0, level=80.0)) == []
    assert undone_after(Refused("lease", "it is held"), lamp(103.0, level=80.0)) == []
    assert undone_after(NoAnswer(2.0), lamp(103.0, level=80.0)) == [LAMP], "it obeyed late"


def test_after_a_restart_a_value_comes_back_if_it_is_as_it_was_reported() -> None:
    """Nobody knows how old the first value since then is."""
    confirmed, now = Confirmed(0.5, Evidence.REPORTED, reported={"level": 80.0}), lamp(500.0, level=80.0)
    first = {place: state.model_copy(update={"is_first": True}) for place, state in now.items()}
    dimmed = {place: state.model_copy(update={"value": Value.of(30.0)}) for place, state in first.items()}
    assert [undone_after(confirmed, one) for one in (first, now, dimmed)] == [[LAMP], [], []]
    assert undone_after(NoAnswer(2.0), first) == []


def test_a_second_command_that_changed_nothing_keeps_what_the_first_one_was_reported_for_a_restart() -> None:
    earlier = EarlierValues()
    confirmed = Confirmed(0.5, Evidence.REPORTED, reported={"on_off": True})
    earlier.add(lamp(1.0, on_off=False), [commanded(confirmed)], 100.0, 101.0)
    earlier.add(lamp(100.5, on_off=True), [commanded(AlreadySo())], 200.0, 201.0)
    first = {place: one.model_copy(update={"is_first": True}) for place, one in lamp(500.0, on_off=True).items()}
    assert earlier.due(first) == {LAMP: (Setting.of("on_off", False),)}
