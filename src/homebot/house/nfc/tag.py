"""A simulated tag of a house, which people hold to its reader."""

from __future__ import annotations

from collections.abc import Callable

import anyio

from homebot.conventions.nfc.ndef_message import NdefRecord, write_ndef
from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.dialects.wire import hardware_address
from homebot.house.nfc.field import TagField
from homebot.house.nfc.type4_card import Type4Card
from homebot.house.tag import AWAY

__all__ = ["ServedTag"]


class ServedTag(ServedDevice):
    """A tag with a text, and its room as its area.

    Args:
        on_command: Never called: tags take no commands through a reader.
        field: The field of the reader, which has room for one tag; the last one counts.
    """

    def __init__(self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], field: TagField) -> None:
        super().__init__(device, on_command)
        self._field = field
        self._card = Type4Card(bytes.fromhex(f"04{hardware_address(device)[:12]}"))

    async def serve(self) -> None:
        """Do nothing: it is at the reader, or away."""
        await anyio.sleep_forever()

    def show(self) -> None:
        """Hold the tag to the reader, or take it away."""
        if self.state.text != AWAY:
            self._card.put(write_ndef(NdefRecord("text", f"{self.state.text}\narea: {self.device.room}".encode())))
            self._field.card = self._card
        elif self._field.card is self._card:
            self._field.card = None
