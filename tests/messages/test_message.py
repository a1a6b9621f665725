"""What a message accepts, and what it refuses."""

import copy
import pickle
from typing import ClassVar

import pytest
from pydantic import ValidationError

from homebot.errors import UsageError
from homebot.messages import Bool, Float64, Int32, Int64, Message, String, Time
from homebot.messages import message as fields
from homebot.messages.rcl_interfaces import ParameterValue


class Numbers(Message):
    int8: fields.Int8 = 0
    int16: fields.Int16 = 0
    int32: fields.Int32 = 0
    int64: fields.Int64 = 0
    uint8: fields.UInt8 = 0
    uint16: fields.UInt16 = 0
    uint32: fields.UInt32 = 0
    uint64: fields.UInt64 = 0
    plain: int = 0
    plains: tuple[int, ...] = ()


BOUNDS = [(f"int{bits}", -(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)]
BOUNDS += [(f"uint{bits}", 0, 2**bits - 1) for bits in (8, 16, 32, 64)]
BOUNDS += [("plain", -(2**63), 2**63 - 1)]


@pytest.mark.parametrize(("name", "least", "greatest"), BOUNDS)
def test_a_whole_number_holds_the_range_of_its_ros_type(name: str, least: int, greatest: int) -> None:
    for value in (least, greatest):
        assert getattr(Numbers.model_validate({name: value}), name) == value
    for value in (least - 1, greatest + 1):
        with pytest.raises(ValidationError, match=name):
            Numbers.model_validate({name: value})


def test_an_element_of_an_array_holds_its_range_too() -> None:
    with pytest.raises(ValidationError, match=r"plains\.1"):
        Numbers(plains=(0, 2**63))


@pytest.mark.parametrize(
    ("message_type", "value"),
    [
        (Int32, 1.0),
        (Int32, True),
        (Int32, "1"),
        (Bool, 1),
        (String, 1),
        (String, b"x"),
        (Float64, "1"),
    ],
)
def test_a_value_of_another_type_is_not_converted(message_type: type[Message], value: object) -> None:
    with pytest.raises(ValidationError, match="data"):
        message_type.model_validate({"data": value})


def test_a_whole_number_is_a_real_one_as_well() -> None:
    assert type(Float64(data=1).data) is float


def test_a_message_cannot_be_changed() -> None:
    message = String(data="x")
    with pytest.raises(ValidationError, match="frozen"):
        setattr(message, "data", "y")  # noqa: B010  # mypy knows that it is frozen


def test_an_unknown_field_is_refused() -> None:
    with pytest.raises(ValidationError, match="dta"):
        String.model_validate({"data": "x", "dta": "y"})


def test_equal_messages_are_equal_keys() -> None:
    assert {String(data="x"): 1}[String(data="x")] == 1


def test_a_message_of_checked_values_is_like_one_that_was_checked() -> None:
    checked = String(data="hello")
    message = String.of_checked(data=checked.data)

    assert message == checked
    assert hash(message) == hash(checked)
    assert repr(message) == repr(checked)
    assert message.model_dump_json() == checked.model_dump_json()
    assert message.model_copy(update={"data": "bye"}) == String(data="bye")
    with pytest.raises(ValidationError, match="frozen"):
        message.data = "changed"  # type: ignore[misc] # it is what is refused


def test_a_message_of_checked_values_is_copied_and_pickled_like_any_other() -> None:
    message = String.of_checked(data="hello")

    pickled = pickle.loads(pickle.dumps(message))  # noqa: S301 - our own
    for same in (copy.copy(message), copy.deepcopy(message), pickled):
        assert same == message
        assert same.model_fields_set == {"data"}
    assert message.model_extra is None
    with pytest.raises(AttributeError, match="no attribute 'date'"):
        message.date  # type: ignore[attr-defined] # noqa: B018 - it is what is refused


def test_messages_of_checked_values_share_no_value() -> None:
    one, other = String.of_checked(data="one"), String.of_checked(data="other")

    assert (one.data, other.data) == ("one", "other")
    assert Int32.of_checked(data=1).model_fields_set == {"data"} == one.model_fields_set


def test_a_copy_with_changes_differs_from_the_message_it_was_made_of() -> None:
    before = Time(sec=1, nanosec=2)
    after = before.model_copy(update={"sec": 3})

    assert (after, before) == (Time(sec=3, nanosec=2), Time(sec=1, nanosec=2))
    assert after.model_fields_set == {"sec", "nanosec"}


def test_slimmed_messages_of_a_type_share_the_names_of_their_fields() -> None:
    one, other = (ParameterValue(type=kind).slimmed() for kind in (1, 2))

    assert one == ParameterValue(type=1)
    assert one.model_fields_set is other.model_fields_set
    assert one.model_fields_set == set(ParameterValue.model_fields)


def test_a_type_is_named_after_its_package_and_class() -> None:
    assert Numbers.ros_type == f"{__name__.partition('.')[0]}/msg/Numbers"


def test_a_subclass_has_a_name_of_its_own() -> None:
    class Text(String):
        pass

    assert Text.ros_type.endswith("/msg/Text")
    assert String.ros_type == "std_msgs/msg/String"


def test_a_key_must_be_a_field() -> None:
    with pytest.raises(UsageError, match="Keyless has no field 'name' to use as its key"):

        class Keyless(Message):
            key_field: ClassVar[str | None] = "name"

            data: str


def test_a_key_may_lie_in_a_nested_message() -> None:
    class Sent(Message):
        key_field: ClassVar[str | None] = "text.data"

        text: String

    assert Sent.key_field == "text.data"


def test_the_schema_for_other_tools_tells_the_range() -> None:
    schema = Int64.model_json_schema()["properties"]["data"]
    assert (schema["minimum"], schema["exclusiveMaximum"]) == (-(2**63), 2**63)
    assert Numbers.model_json_schema()["properties"]["plain"]["minimum"] == -(2**63)
