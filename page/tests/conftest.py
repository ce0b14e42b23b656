"""A browser that loads no other than the page, and runs that it shows."""

import os
import pathlib
import shutil
import signal
import subprocess

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

ROOT = pathlib.Path(__file__).resolve().parents[2]
RPL = pathlib.Path(os.environ.get("RPL", ROOT / "target" / "python" / "bin" / "rpl"))

SWITCHES = [
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--window-size=1400,900",
]


def chromium_driver(profile):
    """A browser of its own."""
    options = Options()
    options.binary_location = shutil.which("chromium") or "/usr/bin/chromium"
    for switch in [*SWITCHES, f"--user-data-dir={profile}"]:
        options.add_argument(switch)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    # With its path given, the library looks for no driver, and downloads none.
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver") or "/usr/bin/chromedriver"))


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    driver = chromium_driver(tmp_path_factory.mktemp("profile"))
    yield driver
    driver.quit()


@pytest.fixture
def browser(chromium):
    """The browser, which has complained of nothing when a test is over."""
    chromium.get("about:blank")
    chromium.get_log("browser")
    yield chromium
    chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    # That a server is gone is what the page tells by itself.
    complaints = [entry["message"] for entry in chromium.get_log("browser") if "net::ERR_" not in entry["message"]]
    assert not complaints


@pytest.fixture
def rpl(tmp_path):
    """Runs the command in a folder of its own, to its end."""

    def run(*arguments):
        return subprocess.run([RPL, *map(str, arguments)], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)

    return run


@pytest.fixture
def served(tmp_path):
    """Starts commands that serve a page; gives their links."""
    started = []

    def start(*arguments):
        process = subprocess.Popen([RPL, *map(str, arguments)], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        started.append(process)
        for line in process.stderr:
            if "the run is shown at " in line:
                return line.split("the run is shown at ")[1].strip(), process
        raise AssertionError("no link was printed")

    yield start
    for process in started:
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
        process.wait()
        process.stderr.close()
