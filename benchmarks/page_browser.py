"""The page of a running homebot in Debian's Chromium, in the environment of the tests.

``python page_browser.py URL DEVICES`` prints a JSON line with the ``loaded`` kB, the seconds until it ``painted`` first
and has ``drawn`` a tile of each device, and its ``heap`` then, in MB; for each line on its input one with the ``shown``
changes since then, each with the number in the name of its device and the time of its frame, ``p99`` and ``longest`` of
its frames in milliseconds, and the ``heap``; the job ``rest`` gives the ``heap`` alone, and ends the watch, which costs
memory itself. The end of its input ends it.
"""

from __future__ import annotations

import json
import os
import sys
import time

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

FLAGS = ("--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--window-size=1200,900")
PAINTED = "return performance.getEntriesByName('first-contentful-paint')[0].startTime"
LOADED = """
const files = [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")];
return files.filter((one) => !/icon/.test(one.name)).reduce((sum, one) => sum + one.encodedBodySize, 0) / 1000;
"""
TILES = "return document.querySelectorAll('.tile').length"
REST = "window.watch_of_bench?.disconnect(); window.watch_of_bench = null"
WATCH = """
window.frames_of_bench = [];
window.shown_of_bench = [];
const after = new MessageChannel(); // what it brings comes after the frame is drawn
after.port1.onmessage = ({ data }) => {
  const at = (performance.timeOrigin + performance.now()) / 1000;
  for (const device of data) window.shown_of_bench.push([device, at]);
};
window.watch_of_bench = new MutationObserver((found) => {
  const places = found.map(({ target }) => target.parentElement?.closest(".tile .state")).filter(Boolean);
  const names = places.map((place) => place.closest(".tile").querySelector(".name").textContent);
  after.port2.postMessage(names.map((name) => Number(name.match(/\\d+/))));
});
window.watch_of_bench.observe(document.querySelector("#page"), { subtree: true, characterData: true });
let last = performance.now();
const frame = (now) => {
  window.frames_of_bench.push(now - last);
  last = now;
  if (window.watch_of_bench) requestAnimationFrame(frame);
};
requestAnimationFrame(frame);
"""


def main(url: str, devices: int) -> None:
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in (*FLAGS, *(["--no-sandbox"] if os.geteuid() == 0 else [])):
        options.add_argument(flag)
    browser = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    try:
        started = time.perf_counter()
        browser.get(f"{url}#/lights")
        WebDriverWait(browser, 60, 0.02).until(lambda page: page.execute_script(TILES) == devices)
        drawn = time.perf_counter() - started
        greeting = {"loaded": browser.execute_script(LOADED), "painted": browser.execute_script(PAINTED) / 1e3}
        print(json.dumps({**greeting, "drawn": drawn, "heap": heap(browser)}), flush=True)
        browser.execute_script(WATCH)
        for line in sys.stdin:
            if json.loads(line)["job"] == "rest":
                browser.execute_script(REST)
                print(json.dumps({"heap": heap(browser)}), flush=True)
                continue
            frames = sorted(browser.execute_script("return window.frames_of_bench.splice(0)"))
            shown = browser.execute_script("return window.shown_of_bench.splice(0)")
            found = {"shown": shown, "p99": frames[int(0.99 * len(frames))], "longest": frames[-1]}
            print(json.dumps({**found, "heap": heap(browser)}), flush=True)
    finally:
        browser.quit()


def heap(browser: webdriver.Chrome) -> float:
    """Return the MB that the program of the page holds after a collection."""
    browser.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
    return float(browser.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"]) / 1e6


main(sys.argv[1], int(sys.argv[2]))
