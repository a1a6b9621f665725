"""The gateway of NFC tags and QR codes, which point to devices."""

from homebot.gateways.nfc.gateway import NfcGateway
from homebot.gateways.nfc.settings import NfcGatewaySettings

__all__ = ["NfcGateway", "NfcGatewaySettings"]
