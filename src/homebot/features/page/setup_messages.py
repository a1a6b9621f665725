"""Messages about the setup of homebot by its page."""

from typing import Annotated

from pydantic import ConfigDict, Field

from homebot.devices.value import ShortText
from homebot.gateways.pairing import UnpairedDevice
from homebot.messages.key_value import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType


class UnusedDevices(Message):
    """Devices in the network that no gateway uses yet.

    Attributes:
        gateway: The plug-in that could use them, such as ``hue``: the name of the table ``[gateways.hue]``.
        devices: Their ids.
        names: Their names, in the same order.
        next: The next step in words, such as a table to add or a button to press.
        url: The address of a server on this computer, for the key ``url``; empty for others.
    """

    gateway: str
    devices: tuple[str, ...]
    names: tuple[str, ...]
    next: str
    url: str = ""


class UnpairedOfGateway(Message):
    """A device that waits to be paired by the service ``pair`` of its gateway.

    Attributes:
        unpaired: It, as its gateway knows it.
    """

    gateway: str
    unpaired: UnpairedDevice


class FindUnusedRequest(Message):
    """Request for the devices that could be used."""


class FindUnusedResponse(Message):
    """The devices that could be used, by gateway.

    Attributes:
        file: The configuration that :data:`ChangeSetup` changes; empty if homebot runs without one.
        unpaired: The devices that a gateway knows, and could pair.
        gateways: The names of the gateways that run, but for those of tables of their own, such as ``people``.
        acting: Those of the configuration that say ``act = true``.
        can_restart: Whether homebot can begin again by itself.
    """

    unused: tuple[UnusedDevices, ...] = ()
    unpaired: tuple[UnpairedOfGateway, ...] = ()
    file: str = ""
    gateways: tuple[str, ...] = ()
    acting: tuple[str, ...] = ()
    can_restart: bool = False


class ChangeSetupRequest(Message):
    """A change of one table of the configuration, which is then reloaded.

    Attributes:
        table: The names of the table from the outermost, such as ``gateways`` and ``hue``; it is made if it is missing.
            Empty to take out the table that *remove* names.
        values: Keys with values as in TOML: ``true``, ``"a text"``, ``[1, 2]``. An address as :data:`ReadTable` shows
            it stands for that of the file.
        remove: Keys to take out.
        secrets: The ``password`` or ``token`` of a gateway, each for a file beside the configuration, which only its
            owner can read, and the key ``password_file`` or ``token_file`` that names it.
        undo: Whether to take the last change back instead, unless the file has changed since.
        restart: Whether homebot begins again now, as a change of gateways needs, instead of a change.
    """

    model_config = ConfigDict(hide_input_in_errors=True)

    table: Annotated[tuple[ShortText, ...], Field(max_length=4)] = ()
    values: Annotated[tuple[KeyValue, ...], Field(max_length=50)] = ()
    remove: Annotated[tuple[ShortText, ...], Field(max_length=50)] = ()
    secrets: Annotated[tuple[KeyValue, ...], Field(max_length=2, repr=False)] = ()
    undo: bool = False
    restart: bool = False


class ChangeSetupResponse(ServiceAnswer):
    """The outcome; the message names the changes that wait for a restart. One with a mistake leaves the file as it was.

    Attributes:
        lines: The lines of the file that are new.
    """

    lines: tuple[str, ...] = ()


class ReadTableRequest(Message):
    """Request for a table of the configuration that :data:`ChangeSetup` changes, but for one of a gateway.

    Attributes:
        table: The names of the table from the outermost.
    """

    table: Annotated[tuple[ShortText, ...], Field(min_length=1, max_length=4)]


class ReadTableResponse(ServiceAnswer):
    """The table as it is in the file.

    Attributes:
        values: Its keys with values in JSON. Of addresses only the scheme and the end are shown, as they have secrets.
    """

    values: tuple[KeyValue, ...] = ()


class BackupRequest(Message):
    """Request for a backup, in parts.

    Attributes:
        offset: The first byte of the part; 0 makes a new backup, in place of the one before.
    """

    offset: Annotated[int, Field(ge=0)] = 0


class BackupResponse(ServiceAnswer):
    """A part of the backup, as ``homebot backup`` writes it, without secrets.

    Attributes:
        name: A name for the file.
        size: That of all parts, in bytes. After the last one the backup is gone.
        left_out: Files that it lacks because they have secrets.
    """

    name: str = ""
    size: int = 0
    data: bytes = b""
    left_out: tuple[str, ...] = ()


class MakeTokenRequest(Message):
    """Request for a token of a screen or a program, with no more rights than the client itself has.

    Attributes:
        name: Its name: letters, digits, ``-`` and ``_``.
        grants: Its rights: ``read``, ``act: all``, ``act: light in hall``, ``ask: lock``, ``manage``.
        issuer: The client that asks, set by the door, as its own *scope*.
    """

    name: ShortText
    grants: Annotated[tuple[ShortText, ...], Field(min_length=1, max_length=100)]
    issuer: str = ""
    scope: Annotated[tuple[str, ...], Field(max_length=100)] = ()


class MakeTokenResponse(ServiceAnswer):
    """The token.

    Attributes:
        token: The secret, which is told this once, and kept in a file beside the configuration.
    """

    token: str = ""


FindUnused = ServiceType("homebot/srv/FindUnused", FindUnusedRequest, FindUnusedResponse)
ReadTable = ServiceType("homebot/srv/ReadTable", ReadTableRequest, ReadTableResponse)
GetBackup = ServiceType("homebot/srv/GetBackup", BackupRequest, BackupResponse)
ChangeSetup = ServiceType("homebot/srv/ChangeSetup", ChangeSetupRequest, ChangeSetupResponse)
MakeToken = ServiceType("homebot/srv/MakeToken", MakeTokenRequest, MakeTokenResponse)
