"""The page of a running homebot in Debian's Chromium, in the environment of the tests.

``python page_browser.py URL DEVICES`` prints a JSON line with the seconds until it ``painted`` first and has ``listed``
all devices, and the ``heap`` of its program then, in MB; for each line on its input one with the ``changes`` of texts
since then, and ``p99`` and ``longest`` of its frames in milliseconds. The end of its input ends it.
"""

from __future__ import annotations

import json
import os
import sys
import time

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

FLAGS = ("--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--window-size=1200,900")
PAINTED = "return performance.getEntriesByName('first-contentful-paint')[0].startTime"
WATCH = """
window.frames_of_bench = [];
let last = performance.now();
window.changes_of_bench = [];
new MutationObserver((found) => window.changes_of_bench.push(...found))
  .observe(document.querySelector("#page"), { subtree: true, characterData: true });
const frame = (now) => { window.frames_of_bench.push(now - last); last = now; requestAnimationFrame(frame); };
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
        browser.get(url)
        WebDriverWait(browser, 60, 0.02).until(
            lambda page: f"{devices} devices" in page.find_element(By.CSS_SELECTOR, "[role=status]").text
        )
        listed = time.perf_counter() - started
        painted = browser.execute_script(PAINTED) / 1e3
        browser.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
        heap = browser.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"] / 1e6
        print(json.dumps({"listed": listed, "painted": painted, "heap": heap}), flush=True)
        browser.execute_script(WATCH)
        for _line in sys.stdin:
            frames = sorted(browser.execute_script("return window.frames_of_bench.splice(0)")) or [0.0]
            changes = browser.execute_script("return window.changes_of_bench.splice(0).length")
            found = {"changes": changes, "p99": frames[int(0.99 * len(frames))], "longest": frames[-1]}
            print(json.dumps(found), flush=True)
    finally:
        browser.quit()


main(sys.argv[1], int(sys.argv[2]))
