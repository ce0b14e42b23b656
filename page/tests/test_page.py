"""The page in a browser: what is in the picture, and where."""

import json
import math

import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

VALVE = "valve.rpl"
DELIVERY = ("delivery.rpl", "--world", "dept", "--seed", "7")


def until(browser, condition, seconds=20):
    return WebDriverWait(browser, seconds, poll_frequency=0.05).until(lambda _: condition())


def find(browser, css):
    return browser.find_element(By.CSS_SELECTOR, css)


def script(browser, code, *arguments):
    return browser.execute_script(code, *arguments)


def texts(browser, css):
    # All at once: the page may take a node away between finding it and asking for its text.
    return script(browser, "return [...document.querySelectorAll(arguments[0])].map((node) => node.innerText.trim());", css)


def shown_s(browser):
    return float(find(browser, "[role=slider]").get_attribute("aria-valuenow"))


def end_s(browser):
    return float(find(browser, "[role=slider]").get_attribute("aria-valuemax"))


def seek(browser, share):
    script(browser, """
        const paper = document.querySelector(".paper"), box = paper.getBoundingClientRect();
        const at = { clientX: box.left + arguments[0] * box.width, clientY: box.top + 5, pointerId: 1, bubbles: true };
        paper.setPointerCapture = () => {};
        for (const kind of ["pointerdown", "pointerup"]) paper.dispatchEvent(new PointerEvent(kind, at));""", share)


def press(browser, key):
    find(browser, "body").send_keys(key)


def opened(browser, link):
    browser.get(str(link))
    until(browser, lambda: browser.find_elements(By.CSS_SELECTOR, ".run"))


@pytest.fixture
def report(rpl, tmp_path):
    """A report of a run with a robot."""
    path = tmp_path / "run.html"
    done = rpl("run", *DELIVERY, "--report", path, "--truth", "--trace", "run.jsonl", "--trace-poses", "5", "-q")
    assert done.returncode == 0, done.stderr
    return path


def test_a_report_opens_without_a_network_and_shows_the_run(browser, report):
    browser.execute_cdp_cmd("Network.enable", {})
    browser.execute_cdp_cmd("Network.emulateNetworkConditions", {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0})
    opened(browser, report.as_uri())
    assert "delivery.rpl" in browser.title
    assert any("mail" in line for line in texts(browser, ".plan code"))
    assert "main" in script(browser, "return [...document.querySelectorAll('.bar')].map((bar) => bar.dataset.path)")
    outside = script(browser, "return performance.getEntriesByType('resource').map((one) => one.name).filter((name) => !name.startsWith('data:'))")
    assert outside == []
    browser.execute_cdp_cmd("Network.emulateNetworkConditions", {"offline": False, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1})


def test_the_robot_stands_where_the_trace_says(browser, report, tmp_path):
    poses = [json.loads(line) for line in (tmp_path / "run.jsonl").read_text().splitlines() if '"kind":"pose"' in line]
    opened(browser, report.as_uri())
    for share in (0.25, 0.6, 0.9):
        seek(browser, share)
        time_s = share * end_s(browser)
        until(browser, lambda: abs(shown_s(browser) - time_s) < 0.2)
        place = script(browser, "const m = document.querySelector('.robot.estimate').transform.baseVal[0].matrix; return [m.e / 1000, -m.f / 1000]")
        nearest = min(poses, key=lambda pose: abs(pose["time_s"] - time_s))
        assert math.dist(place, nearest["estimated"][:2]) < 0.25
        inside = script(browser, """
            const map = document.querySelector("svg.map").getBoundingClientRect();
            const robot = document.querySelector(".robot.estimate circle").getBoundingClientRect();
            return robot.left >= map.left && robot.right <= map.right && robot.top >= map.top && robot.bottom <= map.bottom;""")
        assert inside


def test_what_is_believed_sensed_and_wanted_is_drawn(browser, report):
    opened(browser, report.as_uri())
    seek(browser, 0.2)
    until(browser, lambda: find(browser, "path.rays").get_attribute("d"))
    rays = find(browser, "path.rays").get_attribute("d").count("M")
    assert 5 < rays <= 36
    assert find(browser, "image.belief").get_attribute("href").startswith("data:image/png")
    until(browser, lambda: browser.find_elements(By.CSS_SELECTOR, ".targets circle"))
    assert find(browser, ".scale span").text.endswith(" m")
    assert script(browser, "return document.querySelectorAll('.solids path').length") > 0


def test_one_goes_back_event_by_event_and_on_again(browser, rpl, tmp_path):
    path = tmp_path / "valve.html"
    rpl("run", VALVE, "--report", path, "-q")
    opened(browser, path.as_uri())
    assert shown_s(browser) == 8
    assert texts(browser, ".log li span")[-1] == "8 s: clean"
    press(browser, Keys.HOME)
    until(browser, lambda: shown_s(browser) == 0)
    seek(browser, 4 / 8)
    until(browser, lambda: len(browser.find_elements(By.CSS_SELECTOR, ".tree li")) == 3)
    assert find(browser, "[data-valve=wheels] .holder").text == "with-policy[0] answer-the-door"
    marked = texts(browser, "mark:not(.around)")
    assert marked == ["(wait-time 6)", "(wait-time 5)"]
    assert [mark.get_attribute("class") for mark in browser.find_elements(By.CSS_SELECTOR, "mark:not(.around)")] == ["suspended", "waits"]
    before = shown_s(browser)
    press(browser, Keys.ARROW_LEFT)
    until(browser, lambda: shown_s(browser) < before)
    press(browser, Keys.ARROW_RIGHT)
    until(browser, lambda: shown_s(browser) >= 2)


def test_why_follows_the_causes(browser, rpl, tmp_path):
    path = tmp_path / "valve.html"
    rpl("run", VALVE, "--report", path, "-q")
    opened(browser, path.as_uri())
    seek(browser, 4 / 8)
    until(browser, lambda: browser.find_elements(By.CSS_SELECTOR, ".tree li.suspended"))
    find(browser, ".tree li.suspended").click()
    until(browser, lambda: texts(browser, ".why li"))
    chain = texts(browser, ".why li")
    assert "wheels was taken from it by" in chain
    assert any(line.startswith("main/with-policy[0]/answer-the-door waits for time") for line in chain)


def test_two_runs_stand_side_by_side(browser, served, rpl):
    for seed in ("7", "8"):
        rpl("run", "delivery.rpl", "--world", "dept", "--seed", seed, "--trace", f"{seed}.jsonl", "--trace-poses", "5", "-q")
    link, _ = served("view", "7.jsonl", "8.jsonl", "--at", ":0")
    opened(browser, link)
    runs = browser.find_elements(By.CSS_SELECTOR, ".run")
    assert len(runs) == 2 and len(browser.find_elements(By.CSS_SELECTOR, ".robot.estimate")) == 2
    left, right = (run.rect for run in runs)
    assert left["x"] + left["width"] <= right["x"] and abs(left["y"] - right["y"]) < 1


def test_it_fits_a_phone_and_a_projector_in_both_themes(browser, report):
    for width in (390, 1920):
        for theme in ("light", "dark"):
            browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": width < 500})
            browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": theme}]})
            opened(browser, report.as_uri())
            assert script(browser, "return document.documentElement.scrollWidth <= innerWidth")
            contrast = script(browser, """
                const light = (colour) => { const [r, g, b] = colour.match(/[\\d.]+/g).map((n) => { n /= 255; return n <= .03928 ? n / 12.92 : ((n + .055) / 1.055) ** 2.4; }); return .2126 * r + .7152 * g + .0722 * b; };
                const panel = light(getComputedStyle(document.querySelector(".panel")).backgroundColor);
                return ["body", ".tree .does", ".panel h2"].map((css) => { const ink = light(getComputedStyle(document.querySelector(css) ?? document.body).color); return (Math.max(ink, panel) + .05) / (Math.min(ink, panel) + .05); });""")
            assert min(contrast) >= 4.5, (width, theme, contrast)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_whatever_can_be_pressed_has_a_name(browser, report):
    opened(browser, report.as_uri())
    nameless = script(browser, """
        return [...document.querySelectorAll("button, input, select, [role=slider], svg[role=img]")]
          .filter((node) => !(node.getAttribute("aria-label") || node.textContent.trim() || node.closest("label")?.textContent.trim() || node.hidden))
          .map((node) => node.outerHTML)""")
    assert nameless == []


def test_a_run_that_goes_on_is_followed(browser, served):
    link, _ = served("run", *DELIVERY, "--live", ":0", "--realtime", "4")
    opened(browser, link)
    first = until(browser, lambda: end_s(browser) > 1 and shown_s(browser))
    until(browser, lambda: shown_s(browser) > first + 2)
    assert find(browser, "#connection").text.endswith("live")
    assert not find(browser, "#steering").is_displayed()


def test_it_survives_being_loaded_anew_and_a_connection_that_is_lost(browser, served):
    link, _ = served("run", *DELIVERY, "--live", ":0", "--realtime", "4")
    opened(browser, link)
    until(browser, lambda: shown_s(browser) > 1)
    reached = end_s(browser)
    browser.refresh()
    until(browser, lambda: browser.find_elements(By.CSS_SELECTOR, ".run"))
    until(browser, lambda: end_s(browser) >= reached)
    browser.execute_cdp_cmd("Network.enable", {})
    gone = {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
    browser.execute_cdp_cmd("Network.emulateNetworkConditions", gone)
    until(browser, lambda: find(browser, "body").get_attribute("data-state") == "lost")
    lost = end_s(browser)
    browser.execute_cdp_cmd("Network.emulateNetworkConditions", {**gone, "offline": False, "downloadThroughput": -1, "uploadThroughput": -1})
    until(browser, lambda: end_s(browser) > lost + 1)
    times = script(browser, "return document.querySelectorAll('.bar').length")
    assert times > 0
    browser.get_log("browser")


def test_a_run_is_held_stepped_and_stopped_at_a_line(browser, served):
    link, process = served("run", VALVE, "--live", ":0", "--control", "--realtime", "0.1")
    assert "token=" in link
    opened(browser, link)
    until(browser, lambda: find(browser, "#steering").is_displayed())
    find(browser, "#run-pause").click()
    until(browser, lambda: find(browser, "body").get_attribute("data-state") == "paused")
    find(browser, "#break").send_keys("17", Keys.ENTER)
    until(browser, lambda: texts(browser, "#breaks button") == ["line 17 ×"])
    Select(find(browser, "#run-pace")).select_by_visible_text("fastest")
    find(browser, "#run-pause").click()
    until(browser, lambda: find(browser, "#note").text == "stopped at line 17")

    def stands():
        return script(browser, """
            const mark = document.querySelector("mark.before");
            return mark && [mark.closest(".row").querySelector(".number").textContent, mark.textContent];""")

    until(browser, stands)
    here = stands()
    assert here[0] == "17"
    assert shown_s(browser) <= 3.05
    find(browser, "#run-over").click()
    until(browser, lambda: stands() and stands() != here)
    # A line stops the run at each of its forms.
    find(browser, "#breaks button").click()
    until(browser, lambda: texts(browser, "#breaks button") == [])
    find(browser, "#run-pause").click()
    until(browser, lambda: find(browser, "body").get_attribute("data-state") == "ended")
    assert process.poll() is None, "the page stays until Ctrl-C"
