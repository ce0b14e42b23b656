"""What the page costs a run, and how quickly it shows one: `python page/tests/speed.py`, with RPL as for the tests.

Prints a table: pictures in a second while ten minutes of an office day are followed at pace 20, the time of that run with
and without somebody looking, and how long a finished hour among people takes to open and to show any instant.
"""

import pathlib
import resource
import subprocess
import tempfile
import time

from conftest import RPL, chromium_driver
from selenium.webdriver.common.by import By

DAY = ("office.rpl", "--world", "dept-staffed", "--scenario", "experiments/office-day.rpl", "--seed", "3", "-q")
MISSION = (*DAY, "--until", "10min")
PACED = ("--realtime", "20")
INSTANTS = 60

COUNTER = """
window.pictures = 0; window.since = performance.now();
requestAnimationFrame(function count() { window.pictures += 1; requestAnimationFrame(count); });"""

SEEK = """
const [share, done] = arguments, paper = document.querySelector(".paper"), box = paper.getBoundingClientRect();
const at = { clientX: box.left + share * box.width, clientY: box.top + 5, pointerId: 1, bubbles: true };
paper.setPointerCapture = () => {};
const begun = performance.now();
for (const kind of ["pointerdown", "pointerup"]) paper.dispatchEvent(new PointerEvent(kind, at));
// Drawn in the next frame, and on the screen when the one after it begins.
requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now() - begun)));"""


def run_s(folder, *words):
    """Seconds of a run that nobody looks at, and of the processor."""
    begun = time.perf_counter()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([RPL, "run", *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter() - begun, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def followed(driver, folder):
    """Pictures in a second while a run is followed, the seconds it took, and those of its processor."""
    words = [RPL, "run", *MISSION, *PACED, "--live", ":0"]
    process = subprocess.Popen(words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    begun = time.perf_counter()
    link = next(line for line in process.stderr if "the run is shown at " in line).split("the run is shown at ")[1]
    driver.get(link.strip())
    driver.execute_script(COUNTER)
    while driver.find_element(By.TAG_NAME, "body").get_attribute("data-state") != "ended":
        time.sleep(0.05)
    took_s = time.perf_counter() - begun
    pictures = driver.execute_script("return window.pictures * 1000 / (performance.now() - window.since)")
    ticks = (pathlib.Path("/proc") / str(process.pid) / "stat").read_text().rsplit(")", 1)[1].split()
    process.kill()
    process.wait()
    return pictures, took_s, (int(ticks[11]) + int(ticks[12])) / 100


def main():
    with tempfile.TemporaryDirectory() as folder:
        driver = chromium_driver(f"{folder}/profile")
        driver.set_script_timeout(60)
        alone_s, alone_cpu_s = run_s(folder, *MISSION, *PACED)
        pictures, seen_s, seen_cpu_s = followed(driver, folder)
        print(f"followed at pace 20: {pictures:.0f} pictures/s")
        print(f"the run: {alone_s:.2f} s alone, {seen_s:.2f} s seen ({100 * (seen_s / alone_s - 1):+.1f} %)")
        print(f"its processor time: {alone_cpu_s:.2f} s alone, {seen_cpu_s:.2f} s seen")
        report = pathlib.Path(folder) / "hour.html"
        run_s(folder, *DAY, "--report", str(report))
        begun = time.perf_counter()
        driver.get(report.as_uri())
        while not driver.find_elements(By.CSS_SELECTOR, ".run"):
            time.sleep(0.01)
        driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
        print(f"a finished hour: {report.stat().st_size / 1e6:.2f} MB, open after {time.perf_counter() - begun:.2f} s")
        shown_ms = sorted(driver.execute_async_script(SEEK, (7 * one % INSTANTS + 0.5) / INSTANTS) for one in range(INSTANTS))
        print(f"an instant of it: {shown_ms[INSTANTS // 2]:.0f} ms, at most {shown_ms[-1]:.0f} ms")
        driver.quit()


if __name__ == "__main__":
    main()
