"""Answers of WLED to ``/json/si`` as versions 0.13, 0.14 and 0.15 send them, shortened where no part needs it.

Source: WLED, JSON API (https://kno.wled.ge/interfaces/json-api).
"""

import json
from pathlib import Path

_DOCUMENTS = json.loads((Path(__file__).parent / "documents.json").read_text())
BEFORE_0_13 = _DOCUMENTS["BEFORE_0_13"]
RGBW_0_14 = _DOCUMENTS["RGBW_0_14"]
RGB_0_15 = _DOCUMENTS["RGB_0_15"]
TWO_SEGMENTS_0_15 = _DOCUMENTS["TWO_SEGMENTS_0_15"]
WHITES_0_13 = _DOCUMENTS["WHITES_0_13"]
