"""NFC tags, their NDEF messages, and setup codes. Pure."""
