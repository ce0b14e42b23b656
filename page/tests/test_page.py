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
    assert find(browser, "[data-valve=wheels] .holder").text == "answer-the-door"
    marked = texts(browser, "mark:not(.around)")
    assert marked == ["(wait-time 6)", "(wait-time 5)"]
    assert [mark.get_attribute("class") for mark in browser.find_elements(By.CSS_SELECTOR, "mark:not(.around)")] == ["suspended", "waits innermost"]
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
    assert any(line.startswith("answer-the-door waits for time") for line in chain)
    boxes = script(browser, "return ['.task-list', '.why'].map((css) => { const box = document.querySelector(css).getBoundingClientRect(); return [box.top, box.bottom]; })")
    assert boxes[0][1] <= boxes[1][0], "the reason covers no task"


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


ROUND = """; A round without a robot.
(def-failure locked (plan-failure) ())
(def-fluent level 10 "What is left.")
{blank}
(def-plan inspect (place seconds)
  (wait-time seconds)
  (decf (value level) 2.5)
  (log (format "~a inspected" place)))
{blank}
(def-plan try-locked (place)
  (with-failure-handling ((locked (f) (print "left out")))
    (fail locked "~a is locked" place)))
{blank}
(def-plan watch (low)
  (wait-for (< level low))
  (print "low"))
{blank}
(with-policy (watch 3)
  (seq (inspect 'stove 4)
       (try-locked 'cellar)
       (:tag washing (inspect 'basin 6))
       (inspect 'bedside 10)))
{blank}
{end}
"""

SIZES = [(1366, 768), (1920, 1080), (390, 844)]


def round_text(end="(print \"done\")"):
    # Far apart, so that what runs is not in view by itself.
    return ROUND.format(blank="\n" * 60, end=end)


@pytest.fixture
def round_report(rpl, tmp_path):
    """A report of a run without a robot that calls plans with arguments."""

    def written(name="round", end="(print \"done\")"):
        (tmp_path / f"{name}.rpl").write_text(round_text(end))
        path = tmp_path / f"{name}.html"
        done = rpl("run", f"{name}.rpl", "--report", path, "-q")
        assert path.exists(), done.stderr
        return path

    return written


def go_to_second(browser, second):
    seek(browser, second / end_s(browser))
    until(browser, lambda: abs(shown_s(browser) - second) < 0.2)


def in_view(browser, css):
    return script(browser, """
        const node = document.querySelector(arguments[0]), list = node?.closest(".text");
        if (!node) return false;
        const [inner, outer] = [node.getBoundingClientRect(), list.getBoundingClientRect()];
        return inner.top >= outer.top && inner.bottom <= outer.bottom;""", css)


def turn_to_tree(browser):
    script(browser, "[...document.querySelectorAll('.tabs button')].at(-1).click()")
    until(browser, lambda: browser.find_elements(By.CSS_SELECTOR, ".plan-nodes .plan-node"))


def tree_states(browser):
    return dict(script(browser, """
        return [...document.querySelectorAll(".plan-nodes .plan-node")].map((node) => [node.querySelector(".name").textContent.slice(2), node.dataset.state]);"""))


def emulate(browser, width, height, theme="light"):
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500})
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": theme}]})


def test_the_innermost_form_is_in_view_unless_the_reader_has_turned_the_text(browser, round_report):
    opened(browser, round_report().as_uri())
    go_to_second(browser, 2)
    until(browser, lambda: in_view(browser, "mark.innermost"))
    assert texts(browser, "mark.innermost") == ["(wait-time seconds)"]
    weights = script(browser, "return ['mark.innermost', 'mark:not(.innermost)'].map((css) => Number(getComputedStyle(document.querySelector(css)).fontWeight))")
    assert weights[0] > weights[1], "it is marked more strongly than the others"
    script(browser, """
        const list = document.querySelector(".text");
        list.dispatchEvent(new WheelEvent("wheel"));
        list.scrollTop = 0;""")
    press(browser, Keys.HOME)
    go_to_second(browser, 15)
    assert script(browser, "return document.querySelector('.text').scrollTop") == 0


def test_tasks_are_called_by_plan_and_arguments_or_by_tag(browser, round_report):
    opened(browser, round_report().as_uri())
    go_to_second(browser, 2)
    until(browser, lambda: "inspect 'stove 4" in texts(browser, ".tree .name"))
    assert "watch 3" in texts(browser, ".tree .name")
    go_to_second(browser, 7)
    until(browser, lambda: "washing: inspect 'basin 6" in texts(browser, ".tree .name"))
    paths = script(browser, "return [...document.querySelectorAll('.tree li')].map((row) => row.title)")
    assert any("main/with-policy[1]/washing/inspect" in path for path in paths)
    bars = script(browser, "return [...document.querySelectorAll('.bar')].map((bar) => bar.getAttribute('aria-label'))")
    assert any(bar.startswith("inspect 'bedside 10: succeeded, 10.0 s to 20.0 s") for bar in bars)
    shown = script(browser, "return [...document.querySelectorAll('.tree .name, .bar text, .valves, .log')].map((node) => node.textContent).join(' ')")
    assert "with-policy[" not in shown
    find(browser, ".tree li[data-path$=washing]").click()
    until(browser, lambda: any(line.startswith("washing: inspect 'basin 6 waits for time") for line in texts(browser, ".why li")))


def test_no_text_is_small_nothing_overflows_and_nothing_is_covered(browser, report):
    for width, height in SIZES:
        for theme in ("light", "dark"):
            emulate(browser, width, height, theme)
            opened(browser, report.as_uri())
            go_to_second(browser, 20)
            script(browser, "document.querySelector('.legend').open = true")
            too_small = """
                return [...document.querySelectorAll("body *")].flatMap((node) => {
                  const own = [...node.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim());
                  if (!own || ["SCRIPT", "STYLE", "TITLE", "title", "OPTION"].includes(node.tagName) || !node.getClientRects().length) return [];
                  const scale = node instanceof SVGElement ? node.getScreenCTM().a : 1;
                  const size = parseFloat(getComputedStyle(node).fontSize) * scale;
                  return size < 10.99 ? [`${node.tagName}.${node.getAttribute("class")} ${size}: ${node.textContent}`] : [];
                })"""
            # The map is laid out in the frame after the one in which it has its size.
            script(browser, "window.frames = 0; requestAnimationFrame(function count() { window.frames += 1; requestAnimationFrame(count); })")
            until(browser, lambda: script(browser, "return window.frames") > 3)
            assert script(browser, too_small) == [], (width, theme)
            assert script(browser, "return document.documentElement.scrollWidth <= innerWidth"), (width, theme)
            covered = script(browser, """
                const box = (css) => document.querySelector(css).getBoundingClientRect();
                const map = box("svg.map");
                return [".legend", ".map-tools", ".velocity", ".scale", ".whereabouts"].filter((css) => {
                  const other = box(css);
                  return other.left < map.right - 1 && other.right > map.left + 1 && other.top < map.bottom - 1 && other.bottom > map.top + 1;
                })""")
            assert covered == [], (width, theme)
            if width > 1000:
                assert script(browser, "return document.querySelector('.run').getBoundingClientRect().bottom <= document.querySelector('.time').getBoundingClientRect().top")
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_places_and_doors_are_drawn_and_what_is_not_in_the_map(browser, rpl, tmp_path):
    path = tmp_path / "furnished.html"
    (tmp_path / "stay.rpl").write_text("(wait-time 5)")
    (tmp_path / "closes.rpl").write_text("(wait-time 2) (close-door! 'b)")
    done = rpl("run", "stay.rpl", "--world", "dept-furnished", "--scenario", "closes.rpl", "--report", path, "--truth", "-q")
    assert done.returncode == 0, done.stderr
    opened(browser, path.as_uri())
    assert "mail-slots" in script(browser, "return [...document.querySelectorAll('.names text.place')].filter((node) => node.getAttribute('display') !== 'none').map((node) => node.textContent)")

    def closed():
        doors = script(browser, "return [...document.querySelectorAll('.doors path')].map((door) => door.dataset.door)")
        assert "open" in doors
        return doors.count("closed")

    after = closed()
    seek(browser, 0.1)
    until(browser, lambda: closed() == after - 1)
    assert len(browser.find_elements(By.CSS_SELECTOR, ".people circle")) == 4
    assert len(browser.find_elements(By.CSS_SELECTOR, ".things path")) > 3
    drawn = script(browser, "return [...document.querySelectorAll('.names text, .things text')].filter((node) => node.getAttribute('display') !== 'none').map((node) => { const box = node.getBoundingClientRect(); return [box.left, box.top, box.right, box.bottom]; })")
    for at, one in enumerate(drawn):
        for other in drawn[at + 1:]:
            width = min(one[2], other[2]) - max(one[0], other[0])
            height = min(one[3], other[3]) - max(one[1], other[1])
            assert width < 4 or height < 6, "names lie on one another"


def test_people_and_things_need_the_truth(browser, rpl, tmp_path):
    path = tmp_path / "staffed.html"
    (tmp_path / "stay.rpl").write_text("(wait-time 5)")
    rpl("run", "stay.rpl", "--world", "dept-furnished", "--report", path, "-q")
    opened(browser, path.as_uri())
    assert browser.find_elements(By.CSS_SELECTOR, ".people circle, .things path") == []


@pytest.mark.parametrize("source", ["report", "trace"])
def test_curves_show_battery_certainty_speed_and_numeric_fluents(browser, rpl, report, tmp_path, source):
    path = report
    if source == "trace":
        path = tmp_path / "from-trace.html"
        assert rpl("view", "run.jsonl", "--report", path).returncode == 0
    opened(browser, path.as_uri())
    seek(browser, 0.5)
    until(browser, lambda: abs(shown_s(browser) - end_s(browser) / 2) < 0.2)
    for name in ("battery", "position certainty", "speed"):
        curve = find(browser, f"[data-curve='{name}']")
        assert curve.find_element(By.CSS_SELECTOR, ".spark").get_attribute("d").count("V") > 1, name
        low, high, now = (float(curve.find_element(By.CSS_SELECTOR, css).text.split()[0]) for css in (".low", ".high", ".value"))
        assert low <= now + 0.01 and now <= high + 0.01
        assert curve.find_element(By.CSS_SELECTOR, "svg").size["height"] >= 36
    assert float(find(browser, "[data-curve='speed'] .high").text) > 0.1


def test_a_numeric_fluent_has_a_curve(browser, round_report):
    opened(browser, round_report().as_uri())
    curve = find(browser, "[data-curve=level]")
    assert (curve.find_element(By.CSS_SELECTOR, ".low").text, curve.find_element(By.CSS_SELECTOR, ".high").text) == ("2.50", "7.50")


def test_a_failure_is_told_once_and_is_red_only_if_it_ends_the_run(browser, round_report):
    opened(browser, round_report("handled").as_uri())
    lines = script(browser, "return [...document.querySelectorAll('.log li')].filter((line) => line.textContent.includes('is locked')).map((line) => line.className)")
    assert lines == ["failure handled"]
    red = "return [...document.querySelectorAll('.log li.end, .bar.failed, .plan-node.failed')].filter((node) => !node.closest('.tree-key')).length"
    assert script(browser, red) == 0, "what was handled or evaporated is not red"
    opened(browser, round_report("fails", "(seq (par (fail locked \"under a table\") (wait-time 3)))").as_uri())
    lines = script(browser, "return [...document.querySelectorAll('.log li')].filter((line) => line.textContent.includes('under a table')).map((line) => line.className)")
    assert lines == ["failure end"]
    assert script(browser, red) > 0


def test_a_failure_that_is_raised_again_is_the_same_and_one_of_a_retry_is_another(browser, rpl, tmp_path):
    raised = {
        "again": ("(with-failure-handling ((stuck (f) (refail))) (par (fail stuck \"x\") (wait-time 1)))", ["failure end"]),
        "retry": ("(with-retry-counters ((n 2)) (with-failure-handling ((stuck (f) (do-retry n (retry)))) (wait-time 1) (fail stuck \"x\")))", ["failure handled"] * 3),
    }
    for name, (text, kinds) in raised.items():
        (tmp_path / f"{name}.rpl").write_text(f"(def-failure stuck (plan-failure) ())\n{text}")
        path = tmp_path / f"{name}.html"
        rpl("run", f"{name}.rpl", "--report", path, "-q")
        opened(browser, path.as_uri())
        assert script(browser, "return [...document.querySelectorAll('.log li')].filter((line) => line.textContent.includes('stuck: x')).map((line) => line.className)") == kinds


def test_no_two_things_have_the_same_name(browser, served, tmp_path):
    (tmp_path / "round.rpl").write_text(round_text())
    link, _ = served("run", "round.rpl", "--live", ":0", "--control", "--realtime", "2")
    opened(browser, link)
    until(browser, lambda: find(browser, "#steering").is_displayed())
    names = script(browser, "return [...document.querySelectorAll('label')].filter((label) => label.querySelector('select')).map((label) => label.firstChild.textContent.trim())")
    assert len(names) == 2 and len(set(names)) == 2
    assert len(set(script(browser, "return [...document.querySelectorAll('select')].map((one) => one.getAttribute('aria-label'))"))) == 2
    for width, height in SIZES:
        emulate(browser, width, height)
        assert script(browser, "return document.documentElement.scrollWidth <= innerWidth"), width


def test_runs_side_by_side_say_what_differs(browser, served, rpl):
    for seed in ("7", "8"):
        rpl("run", "delivery.rpl", "--world", "dept", "--seed", seed, "--trace", f"{seed}.jsonl", "--trace-poses", "5", "-q")
    link, _ = served("view", "7.jsonl", "8.jsonl", "--at", ":0")
    opened(browser, link)
    facts = script(browser, "return [...document.querySelectorAll('.comparison tbody tr')].map((row) => [row.dataset.fact, ...[...row.querySelectorAll('td')].map((cell) => cell.textContent)])")
    assert ["seed", "7", "8"] in facts and "plan" not in [fact[0] for fact in facts]
    assert "plan delivery.rpl" in find(browser, ".comparison .same").text
    first = find(browser, ".first-difference")
    time_s = min(float(part.split(" s:")[0]) for part in first.text.removeprefix("First difference: ").split(" | "))
    first.click()
    until(browser, lambda: abs(shown_s(browser) - time_s) < 0.11)


def test_the_time_line_reaches_the_end_of_a_run_that_has_just_ended(browser, served, tmp_path):
    # Its last lines come sooner after others than the line is laid out again.
    (tmp_path / "short.rpl").write_text("(wait-time 2) (wait-time 0.1)")
    link, _ = served("run", "short.rpl", "--live", ":0", "--realtime", "1")
    opened(browser, link)
    until(browser, lambda: find(browser, "body").get_attribute("data-state") == "ended")
    until(browser, lambda: end_s(browser) == 2.1)


def test_the_plan_is_drawn_as_a_tree_with_states(browser, round_report):
    opened(browser, round_report().as_uri())
    turn_to_tree(browser)
    go_to_second(browser, 7)
    until(browser, lambda: tree_states(browser).get("inspect 'basin 6") == "waits")
    states = tree_states(browser)
    assert states["main"] == "around" and states["washing"] == "around"
    assert states["inspect 'stove 4"] == "succeeded" and states["inspect 'bedside 10"] == "later"
    assert states["watch 3"] == "waits"
    overlapping = script(browser, """
        const boxes = [...document.querySelectorAll(".plan-nodes .plan-node")].map((node) => node.getBoundingClientRect());
        return boxes.some((one, at) => boxes.slice(at + 1).some((other) => one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom));""")
    assert not overlapping
    script(browser, "document.querySelector(\".plan-nodes [data-path$='washing'] .name\").click()")
    until(browser, lambda: texts(browser, ".why li") and texts(browser, ".why li")[0].startswith("washing: inspect"))


def test_a_tree_of_many_tasks_folds_up_what_is_over(browser, rpl, tmp_path):
    (tmp_path / "many.rpl").write_text("(def-plan step-on (n) (wait-time 1))\n(dotimes (n 300) (step-on n))\n(par-map (n (range 1 40)) (wait-time n))")
    path = tmp_path / "many.html"
    done = rpl("run", "many.rpl", "--report", path, "-q")
    assert done.returncode == 0, done.stderr
    opened(browser, path.as_uri())
    turn_to_tree(browser)
    go_to_second(browser, 200.5)
    until(browser, lambda: any(name.endswith(" over") for name in tree_states(browser)))
    few = len(tree_states(browser))
    assert few < 20
    script(browser, "document.querySelector('.plan-nodes .group .name').click()")
    until(browser, lambda: len(tree_states(browser)) > few + 100)


def test_a_click_on_the_map_measures(browser, report):
    opened(browser, report.as_uri())
    go_to_second(browser, 20)

    def click(x, y):
        script(browser, """
            const map = document.querySelector("svg.map"), box = map.getBoundingClientRect();
            map.setPointerCapture = () => {};
            const [look, at] = [map.viewBox.baseVal, { clientX: 0, clientY: 0, pointerId: 1, bubbles: true }];
            at.clientX = box.left + (arguments[0] * 1000 - look.x) / look.width * box.width;
            at.clientY = box.top + (-arguments[1] * 1000 - look.y) / look.height * box.height;
            for (const kind of ["pointerdown", "pointerup"]) map.dispatchEvent(new PointerEvent(kind, at));""", x, y)

    def measured(name):
        return script(browser, "return document.querySelector(`[data-measure='${arguments[0]}']`)?.textContent", name)

    click(5, 4)
    until(browser, lambda: measured("x"))
    assert math.isclose(float(measured("x").split()[0]), 5, abs_tol=0.1) and math.isclose(float(measured("y").split()[0]), 4, abs_tol=0.1)
    pose = script(browser, "const m = document.querySelector('.robot.estimate').transform.baseVal[0].matrix; return [m.e / 1000, -m.f / 1000]")
    assert math.isclose(float(measured("from the robot").split()[0]), math.dist(pose, (5, 4)), abs_tol=0.15)
    assert measured("nearest place").endswith(" m")
    click(8, 8)
    until(browser, lambda: measured("from the last click"))
    assert math.isclose(float(measured("from the last click").split()[0]), 5, abs_tol=0.15)


def test_states_are_told_apart_without_colour(browser, round_report):
    opened(browser, round_report().as_uri())
    turn_to_tree(browser)
    key = script(browser, """
        return [...document.querySelectorAll(".tree-key .plan-node")].map((node) => { const style = getComputedStyle(node); return [node.textContent[0], style.borderTopStyle, style.borderTopWidth]; })""")
    assert len({sign for sign, *_ in key}) == len(key) >= 6
