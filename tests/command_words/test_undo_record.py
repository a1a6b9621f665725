"""What was before commands comes back, unless something else has changed it since."""

from homebot.command_words.undo_record import KnownStates, KnownValue, UndoRecord
from homebot.devices.command_messages import CommandedPart, CommandResult, Setting
from homebot.devices.device import State
from homebot.devices.journal_messages import KnownCause
from homebot.devices.outcomes import AlreadySo, Confirmed, Evidence, NoAnswer, Outcome, Refused
from homebot.devices.value import PlainValue, Value
from homebot.messages import Time

LAMP = ("lamp", "")
AT = Time.from_seconds(100.0)


def lamp(
    command: str | None = None, *, may_be_person: bool = False, is_first: bool = False, **values: PlainValue
) -> KnownStates:
    """Return the values of a lamp, which *command* brought about; None if control has not seen them change."""
    known: dict[tuple[str, str, str], KnownValue] = {}
    for name, value in values.items():
        state = State(
            part="", capability=name, value=Value.of(value), since=AT, told_at=AT, live=True, is_first=is_first
        )
        cause = KnownCause(
            device="lamp",
            part="",
            capability=name,
            value=Value.of(value),
            command=command or "",
            may_be_person=may_be_person,
        )
        known["lamp", "", name] = KnownValue(state, None if command is None else cause)
    return known


def by_hand(**values: PlainValue) -> KnownStates:
    return lamp("", may_be_person=True, is_first=False, **values)


def undone(before: KnownStates, now: KnownStates) -> dict[tuple[str, str], tuple[Setting, ...]]:
    """Undo the command *c1*."""
    earlier = UndoRecord()
    earlier.add_parts(before, {LAMP: {}}, ["c1"])
    return earlier.due(now)


def test_a_value_that_the_command_brought_about_comes_back() -> None:
    was, now = lamp(on_off=True, level=20.0), lamp("c1", on_off=True, level=80.0)
    assert undone(was, now) == {LAMP: (Setting.of("level", 20.0),)}


def test_a_lamp_that_was_off_is_only_turned_off() -> None:
    """Its level would turn it on again."""
    was, now = lamp(on_off=False, level=20.0), lamp("c1", on_off=True, level=80.0)
    assert undone(was, now) == {LAMP: (Setting.of("on_off", False),)}


def test_what_a_person_changed_later_stays() -> None:
    assert undone(lamp(level=20.0), by_hand(level=80.0)) == {}
    assert undone(lamp(level=20.0), lamp("c2", level=80.0)) == {}, "another command"


def test_a_lamp_that_a_person_turned_off_meanwhile_stays_off() -> None:
    now = {**lamp("c1", level=80.0), **by_hand(on_off=False)}
    assert undone(lamp(on_off=True, level=20.0), now) == {}


def test_a_lock_stays_as_it_is() -> None:
    assert undone(lamp(lock="unlocked"), lamp("c1", lock="locked")) == {}


def test_a_cover_goes_back_to_its_position_without_a_word_for_its_movement() -> None:
    was, now = lamp(position=30.0, movement="opening"), lamp("c1", position=100.0, movement="open")
    assert undone(was, now) == {LAMP: (Setting.of("position", 30.0),)}


def test_a_second_command_keeps_what_was_before_the_first() -> None:
    earlier = UndoRecord()
    earlier.add_parts(lamp(level=20.0), {LAMP: {}}, ["c1"])
    earlier.add_parts(lamp("c1", level=80.0), {LAMP: {}}, ["c2"])
    assert earlier.due(lamp("c2", level=50.0)) == {LAMP: (Setting.of("level", 20.0),)}
    assert earlier.due(lamp("c2", level=50.0)) == {}, "an undo is done once"


def test_it_can_be_kept_as_json() -> None:
    earlier = UndoRecord({"lamp color": [[120.0, 50.0], ["c1"], None]})
    assert earlier.due(lamp("c1", color=(0.0, 100.0))) == {LAMP: (Setting.of("color", (120.0, 50.0)),)}


def commanded(outcome: Outcome, command: str = "c1") -> CommandedPart:
    result = CommandResult.of(outcome).model_copy(update={"command_id": command})
    return CommandedPart(device="lamp", name="Lamp", part="", result=result)


def undone_after(outcome: Outcome, now: KnownStates) -> list[tuple[str, str]]:
    """Undo the command *c1*, which turned the lamp on, with this outcome."""
    earlier = UndoRecord()
    earlier.add(lamp(on_off=False, level=20.0), [commanded(outcome)])
    return list(earlier.due(now))


def test_what_a_person_changed_a_moment_after_the_report_of_the_device_stays() -> None:
    confirmed = Confirmed(0.5, Evidence.REPORTED, reported={"level": 80.0})
    assert undone_after(confirmed, by_hand(level=30.0)) == []
    assert undone_after(confirmed, lamp("c1", level=80.5)) == [LAMP], "the last step of a dimmer"


def test_a_command_without_an_effect_has_nothing_to_bring_back() -> None:
    assert undone_after(AlreadySo(), by_hand(level=80.0)) == []
    assert undone_after(Refused("lease", "it is held"), lamp("c1", level=80.0)) == []
    assert undone_after(NoAnswer(2.0), lamp("c1", level=80.0)) == [LAMP], "it obeyed late"


def test_after_a_restart_a_value_comes_back_if_it_is_as_it_was_reported() -> None:
    """No cause of the first value since then is known."""
    confirmed = Confirmed(0.5, Evidence.REPORTED, reported={"level": 80.0})
    first, later, dimmed = lamp(level=80.0, is_first=True), lamp(level=80.0), lamp(level=30.0, is_first=True)
    assert [undone_after(confirmed, now) for now in (first, later, dimmed)] == [[LAMP], [], []]
    assert undone_after(NoAnswer(2.0), first) == []


def test_a_second_command_that_changed_nothing_keeps_what_the_first_one_was_reported_for_a_restart() -> None:
    earlier = UndoRecord()
    confirmed = Confirmed(0.5, Evidence.REPORTED, reported={"on_off": True})
    earlier.add(lamp(on_off=False), [commanded(confirmed)])
    earlier.add(lamp("c1", on_off=True), [commanded(AlreadySo(), "c2")])
    assert earlier.due(lamp(on_off=True, is_first=True)) == {LAMP: (Setting.of("on_off", False),)}
