"""The page's connection, run by Node with a clock and a WebSocket of its own."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from tests.patience import PATIENCE

import homebot.web

SOURCE = Path(homebot.web.__file__).parent / "source"
SIGNALS = "export const signal = (value) => ({ value });"
PROGRAM = """
let time = 1000; // seconds
let number = 0;
const timers = new Map();
const links = [];
const seen = [];
const answers = {
  "/rosapi/get_time": () => ({ time: { sec: 1_800_000_000 + time, nanosec: 0 } }),
  "/rosapi/rights": () => ({ rights: ["read"] }),
  "/apps/list": () => ({ zone: "Asia/Tokyo" }),
  "/homebot/health": () => ({ home: "Home" }),
};
const storage = { getItem: () => null };
const page = { hidden: false, addEventListener() {} };
Object.defineProperty(globalThis, "performance", { value: { timeOrigin: 0, now: () => time * 1000 } });
Object.assign(globalThis, {
  setTimeout: (call, length) => (timers.set(++number, { call, at: time + length / 1000 }), number),
  clearTimeout: (id) => timers.delete(id),
  location: { origin: "http://house", hash: "" },
  sessionStorage: storage,
  localStorage: storage,
  document: page,
  addEventListener() {},
  WebSocket: class {
    isSilent = links.length === 1;
    asked = 0;
    constructor() { links.push(this); }
    send(text) {
      const { op, service, id } = JSON.parse(text);
      if (op !== "call_service" || this.isSilent) return;
      this.asked += service === "/rosapi/get_time";
      const values = answers[service]();
      this.onmessage({ data: JSON.stringify({ op: "service_response", id, values, result: true }) });
    }
    close() { this.isClosed = true; }
  },
});
const { now, zone } = await import("./clock.js");
const { connect, connection } = await import("./door.js");
const pass = (length) => {
  const end = time + length;
  for (;;) {
    const [next] = [...timers].filter(([, { at }]) => at <= end).sort((a, b) => a[1].at - b[1].at);
    if (!next) break;
    timers.delete(next[0]);
    time = next[1].at;
    next[1].call();
  }
  time = end;
};
const see = () => seen.push([connection.value.state, links.length, links.filter((one) => one.isClosed).length]);
connect();
links[0].onopen();
const clock = now() - time;
pass(3600);
const asked = links[0].asked;
see();
links[0].isSilent = true;
pass(41);
see();
links[1].onopen(); // it opens, and nothing answers either
pass(16);
see();
links[2].onopen();
see();
console.log(JSON.stringify({ clock, asked, zone: zone.value, seen }));
"""


def test_a_link_that_turns_silent_is_asked_every_25_seconds_and_given_up_and_the_house_tells_the_time(
    tmp_path: Path,
) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("not installed: node (apt-get install nodejs)")
    package = tmp_path / "node_modules" / "@preact" / "signals"
    package.mkdir(parents=True)
    (package / "package.json").write_text('{"type": "module", "main": "index.js"}')
    (package / "index.js").write_text(SIGNALS)
    (tmp_path / "package.json").write_text('{"type": "module"}')
    for name in ("clock.js", "door.js"):
        shutil.copy(SOURCE / name, tmp_path)
    (tmp_path / "play.mjs").write_text(PROGRAM)
    done = subprocess.run(
        [node, "play.mjs"], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=PATIENCE
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {
        "clock": 1_800_000_000,
        "asked": 1 + 3600 // 25,
        "zone": "Asia/Tokyo",
        "seen": [["open", 1, 0], ["connecting", 2, 1], ["connecting", 3, 2], ["open", 3, 2]],
    }
