"""Write the whole programs of the guides into a folder, for a checker of types: ``python -m … FOLDER``."""

import re
import sys
from pathlib import Path

from tests.guide import guide

_PROGRAM = re.compile(r"<!-- file: (?P<name>[\w.]+\.py) -->\n```python\n(?P<text>.*?)```", re.DOTALL)
_GUIDES = ("bus", "coming-from", "embed")

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for name in _GUIDES:
        for program in _PROGRAM.finditer(guide(name)):
            place = folder / name / program["name"]
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(program["text"], "utf-8")
