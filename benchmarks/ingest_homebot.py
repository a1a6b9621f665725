"""homebot's gateway and directory against a broker full of retained configs, as ``homebot run`` has them.

``python ingest_homebot.py PORT COUNT`` prints one JSON line, as the other ingest workers.
"""

from __future__ import annotations

import asyncio
import json
import resource
import sys
import time

from bench_ingest import ingest
from homebot.cli.serve import short_collections
from homebot.log import configure_logging

configure_logging(level="error")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
with short_collections():
    found, seconds, cpu = asyncio.run(ingest(int(sys.argv[1]), int(sys.argv[2]), with_directory=True))
grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
print(json.dumps({"found": found, "seconds": seconds, "cpu": cpu, "process": time.process_time(), "memory": grown}))
