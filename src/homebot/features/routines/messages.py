"""Messages about the gallery of ready-made routines, and about sentences to pick."""

from typing import Annotated

from pydantic import Field

from homebot.devices.value import ShortText
from homebot.messages.key_value import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType


class ReadyMadeInput(Message):
    """A device or value that a ready-made routine asks for.

    Attributes:
        label: What it is, for people.
        find: The devices to choose from, as a query; empty for a value.
        default: The value unless another is stated.
    """

    key: str
    label: str = ""
    find: str = ""
    default: str = ""


class ReadyMadeRoutine(Message):
    """A ready-made routine: its name in the gallery, its purpose, and what it asks for."""

    name: str
    about: str
    inputs: tuple[ReadyMadeInput, ...] = ()


class RoutineGalleryRequest(Message):
    """Request for the ready-made routines, or for the text of one.

    Attributes:
        name: The one to fill in; empty for the list.
        inputs: Its devices and values, by their keys.
        language: The language of its texts, such as ``de``; empty for that of the house.
    """

    name: ShortText = ""
    inputs: Annotated[tuple[KeyValue, ...], Field(max_length=20)] = ()
    language: ShortText = ""


class RoutineGalleryResponse(ServiceAnswer):
    """The ready-made routines, or the text of one with its inputs."""

    routines: tuple[ReadyMadeRoutine, ...] = ()
    text: str = ""


ReadRoutineGallery = ServiceType("homebot/srv/ReadRoutineGallery", RoutineGalleryRequest, RoutineGalleryResponse)


class RoutineSentencesRequest(Message):
    """Request for the sentences that a routine may have about a device.

    Attributes:
        device: Its id; empty for what is about none, such as a time.
        language: The language of the sentences, such as ``de``; empty for that of the house.
    """

    device: ShortText = ""
    language: ShortText = ""


class RoutineSentencesResponse(Message):
    """Sentences for each key of a routine; a value to change stands in braces, ``{…}`` for a text."""

    when: tuple[str, ...] = ()
    conditions: tuple[str, ...] = ()
    steps: tuple[str, ...] = ()


ListRoutineSentences = ServiceType(
    "homebot/srv/ListRoutineSentences", RoutineSentencesRequest, RoutineSentencesResponse
)
