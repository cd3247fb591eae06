#!/usr/bin/env python3
"""The report's page in headless Chromium: it opens from its file without a complaint and without another request, its bars are
the numbers of the CSV, what is over the budget is marked, its sliders follow mouse and keys, pointing at a bar names the stage.

page_test.py FIXTURE FOLDER [--screenshot FILE]     FIXTURE writes FOLDER/report.html and FOLDER/report.csv
page_test.py --control FIXTURE FOLDER               damages the page in four ways, each of which the checks must notice
Exit code 77: there is no Chromium here."""
import csv
import math
import shutil
import subprocess
import sys

from browser import Browser

SKIPPED = 77
HALF_PIXEL = 0.5


def check(condition, sentence):
    if not condition:
        raise AssertionError(sentence)


def wait_until_drawn(browser):
    check(browser.ask("document.documentElement.dataset.drawn") == "yes", "the script did not reach its end")
    browser.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))).then(() => 1)")


def check_opens(browser, page):
    check(not browser.complaints, f"the console complains: {browser.complaints}")
    others = [url for url in browser.requests if not url.startswith(("data:", "file://" + page))]
    check(not others, f"the page asks for {others}")
    check(browser.ask("document.querySelectorAll('[src^=http], link[href^=http]').length") == 0, "the page names a server")
    missing = browser.ask("[...document.images].filter(i => !i.naturalWidth).length")
    check(missing == 0, f"{missing} pictures cannot be decoded")


def check_bars(browser, rows):
    """Heights of the bars times the axis' scale, against the CSV, stage by stage."""
    bars = browser.ask("""[...document.querySelectorAll('#timeline rect[data-frame]')].map(r =>
        [+r.dataset.frame, r.dataset.stage, +r.getAttribute('height') * r.ownerSVGElement.dataset.msPerPixel])""")
    scale = browser.ask("+document.querySelector('#timeline svg').dataset.msPerPixel")
    drawn = {(frame, stage): height for frame, stage, height in bars}
    stages = [name[:-6] for name in rows[0] if name.endswith("_units")]
    check(len(stages) >= 4, "the CSV names no stages")
    total = 0
    for row in rows:
        frame, sum_ms = int(row["frame"]), 0.0
        for stage in stages:
            ms = float(row[stage + "_ms"])
            sum_ms += ms
            got = drawn.get((frame, stage), 0.0)
            check(abs(got - ms) <= HALF_PIXEL * scale, f"frame {frame}, {stage}: a bar of {got} ms for {ms} ms")
            total += 1
        between = float(row["elapsed_ms"]) - sum_ms
        got = drawn.get((frame, "other"), 0.0)
        check(abs(got - between) <= HALF_PIXEL * scale, f"frame {frame}: {got} ms between units for {between} ms")
    check(len(bars) >= total, "bars are missing")
    missed = [int(r["frame"]) for r in rows if float(r["elapsed_ms"]) > float(r["budget_ms"])]
    marked = browser.ask("[...document.querySelectorAll('#timeline .miss')].map(m => +m.dataset.frame)")
    check(marked == missed and missed, f"marked as missed {marked}, missed {missed}")


def check_percentiles(browser, told):
    """The 99th percentile is named, or, of too few frames to tell it, the longest frame is."""
    tiles = browser.ask("[...document.querySelectorAll('.tile span')].map(s => s.textContent)")
    check(("99th percentile" in tiles) == told and ("longest frame" in tiles) != told, f"the tiles are {tiles}")
    marks = browser.ask("[...document.querySelectorAll('#histogram-elapsed text')].filter(t => t.textContent === '99 %').length")
    spoken = browser.ask("document.querySelector('#histogram-elapsed svg').getAttribute('aria-label')")
    check(marks == told and ("99th" in spoken) == told, f"the histogram has {marks} marks of 99 %, and says: {spoken}")


def check_other_charts(browser, rows):
    counted = browser.ask("[...document.querySelectorAll('#histogram-elapsed rect')].reduce((n, r) => n + +r.dataset.count, 0)")
    check(counted == len(rows), f"the histogram holds {counted} of {len(rows)} frames")
    runs = browser.ask("""[...document.querySelectorAll('#quality rect[data-level]')].map(r =>
        [+r.dataset.level, +r.dataset.from, +r.dataset.to])""")
    levels = [level for level, begin, end in runs for _ in range(begin, end + 1)]
    check(levels == [int(row["level"]) for row in rows], f"quality is drawn as {runs}")
    levels = browser.ask("data.ladder.length")
    check(browser.ask("document.querySelectorAll('#ladder-table tbody tr').length") == levels and levels >= 2, "a quality level is missing")
    check(browser.ask("document.querySelectorAll('#ladder circle').length") >= 2 * (levels - 1), "the ladder's curve is incomplete")
    check_percentiles(browser, False)
    lit = [row for row in rows if row["light_x"]]
    check(browser.ask("document.querySelectorAll('#light rect').length") == 2 * len(lit), "the light has no colours")
    text = browser.ask("document.body.innerText")
    for word in ('known <run> & "page"', "</script> is text.", "0.125", "seed"):
        check(word in text, f"'{word}' is not on the page")
    unnamed = browser.ask("""[...document.querySelectorAll('svg, img, input, button')].filter(e =>
        !(e.getAttribute('aria-label') || e.alt || e.textContent.trim())).length""")
    check(unnamed == 0, f"{unnamed} elements have no name for a screen reader")


def unwrapped(angles):
    """Without jumps of whole turns."""
    out = []
    for angle in angles:
        while out and angle - out[-1] > 180:
            angle -= 360
        while out and angle - out[-1] < -180:
            angle += 360
        out.append(angle)
    return out


def check_light(browser, rows):
    """The light's curves, in the places where the CSV's numbers belong."""
    lit = [row for row in rows if row["light_x"]]
    sure = [row for row in rows if row["confidence"]]
    check(0 < len(sure) < len(lit) < len(rows), "the fixture has light in all frames, or in none")
    towards = [[float(row["light_" + axis]) for axis in "xyz"] for row in lit]
    expected = {
        "estimate: from the zenith": [math.degrees(math.acos(d[1])) for d in towards],
        "estimate: azimuth, from x towards z": unwrapped([math.degrees(math.atan2(d[2], d[0])) for d in towards]),
        "estimate: contrast": [float(row["contrast"]) for row in lit],
        "estimate: confidence": [float(row["confidence"]) for row in sure],
        "labels: from the zenith": [45, 45],
        "labels: azimuth, from x towards z": [0, 0],
    }
    drawn = {name: [float(pair.split()[1]) for pair in path[1:].split("L")] for name, path in browser.ask(
        "[...document.querySelectorAll('#light path')].map(p => [p.dataset.curve, p.getAttribute('d')])")}
    check(drawn.keys() == expected.keys(), f"curves of the light: {sorted(drawn)}")
    scale = browser.ask("({...document.querySelector('#light svg').dataset})")
    for name, heights in drawn.items():
        share = name.endswith(("contrast", "confidence"))
        bottom, unit = (float(scale[key]) for key in (("shareBottom", "sharePerPixel") if share else ("bottom", "degreesPerPixel")))
        low = 0.0 if share else float(scale["low"])
        check(len(heights) == len(expected[name]), f"{name}: {len(heights)} places for {len(expected[name])} rows")
        for height, value in zip(heights, expected[name]):
            got = low + (bottom - height) * unit
            check(abs(got - value) <= HALF_PIXEL * unit, f"{name}: drawn at {got}, is {value}")


def box_of(browser, selector):
    browser.ask(f"document.querySelector('{selector}').scrollIntoView({{block: 'center'}})")
    return browser.ask(f"(r => [r.left, r.top, r.width, r.height])(document.querySelector('{selector}').getBoundingClientRect())")


def check_slider(browser):
    position = "parseFloat(getComputedStyle(document.querySelector('.compare')).getPropertyValue('--at'))"
    check(browser.ask(position) == 50, "the slider does not begin in the middle")
    left, top, width, height = box_of(browser, ".compare")
    browser.drag(left + 0.5 * width, top + 0.5 * height, left + 0.2 * width, top + 0.4 * height)
    at = browser.ask(position)
    check(abs(at - 20) < 2, f"dragged to a fifth, the slider is at {at} %")
    clip = browser.ask("getComputedStyle(document.querySelector('.compare .before')).clipPath")
    check(f"{100 - at:g}%" in clip, f"at {at} % the left picture is cut by {clip}")
    browser.ask("document.querySelector('.compare input').focus()")
    browser.key("ArrowRight", 39)
    check(browser.ask(position) > at, "the slider does not follow the arrow keys")


def check_hover(browser, rows):
    box_of(browser, "#timeline svg")
    row = rows[-1]
    x, y = browser.ask(f"""(r => [r.left + r.width / 2, r.top + r.height / 2])(document.querySelector(
        '#timeline rect[data-frame="{row["frame"]}"][data-stage="shadow"]').getBoundingClientRect())""")
    browser.mouse("mouseMoved", x, y)
    check(browser.ask("getComputedStyle(tip).visibility") == "visible", "pointing at a bar shows nothing")
    named = browser.ask("tip.querySelector('.now').textContent")
    check(named.startswith("shadow") and f"{float(row['shadow_ms']):.3f} ms" in named, f"pointing at a stage says '{named}'")
    check(f"frame {row['frame']}" in browser.ask("tip.textContent"), "the frame is not named")
    browser.ask("document.querySelector('#timeline svg').focus()")
    browser.key("Home", 36)
    check("frame 1 " in browser.ask("tip.textContent"), "the timeline does not follow the keys")


def check_widths(browser):
    """On a phone nothing but tables may be wider than the screen."""
    browser.call("Emulation.setDeviceMetricsOverride", width=380, height=800, deviceScaleFactor=2, mobile=True)
    browser.ask("new Promise(done => setTimeout(done, 300)).then(() => 1)")
    wide = browser.ask("document.documentElement.scrollWidth")
    check(wide <= 380, f"the page is {wide} pixels wide on a screen of 380")
    browser.call("Emulation.clearDeviceMetricsOverride")


def check_extremes(browser, folder):
    """A run of thousands of frames, whose longest must be seen; and one that was interrupted before its first."""
    browser.open(folder + "/long.html")
    wait_until_drawn(browser)
    drawn = browser.ask("new Set([...document.querySelectorAll('#timeline rect[data-frame]')].map(r => r.dataset.frame)).size")
    check(drawn == 1000, f"{drawn} bars for 3000 frames")
    longest = browser.ask("+document.querySelector('#timeline rect[data-frame=\"1234\"]').dataset.ms")
    check(longest == 3.9, f"the longest frame's bar says {longest} ms")
    check_percentiles(browser, True)
    browser.open(folder + "/empty.html")
    wait_until_drawn(browser)
    check(browser.ask("document.querySelectorAll('#timeline rect[data-frame]').length") == 0, "an empty run has bars")
    odd = browser.ask("[...document.querySelectorAll('svg *')].filter(e => [...e.attributes].some(a => /NaN|Infinity/.test(a.value))).length")
    check(odd == 0, f"{odd} shapes of the empty run have no place")


def check_page(program, page, rows, screenshot=None):
    browser = Browser(program)
    try:
        browser.open(page)
        wait_until_drawn(browser)
        check_opens(browser, page)
        check_bars(browser, rows)
        check_other_charts(browser, rows)
        check_light(browser, rows)
        check_slider(browser)
        check_hover(browser, rows)
        if screenshot:
            browser.screenshot(screenshot)
        check_widths(browser)
        check_extremes(browser, page.rsplit("/", 1)[0])
        check(not browser.complaints, f"the console complains: {browser.complaints}")
    finally:
        browser.close()


def controls(program, page, rows):
    text = open(page, encoding="utf-8").read()
    damages = {
        "a bar for": text.replace("height: Math.max(0, y(from) - y(from + time))", "height: Math.max(0, y(from) - y(from + 1.1 * time))"),
        "contrast: drawn": text.replace("y = v => share.bottom - (share.bottom - share.top) * v", "y = v => share.bottom - (share.bottom - share.top) * v * v"),
        "the slider": text.replace("input.addEventListener('input', follow);", ""),
        "console complains": text.replace("document.documentElement.dataset.drawn", "console.error('no'); document.documentElement.dataset.drawn"),
    }
    for expected, damaged in damages.items():
        check(damaged != text, f"the control '{expected}' changes nothing")
        with open(page, "w", encoding="utf-8") as file:
            file.write(damaged)
        try:
            check_page(program, page, rows)
        except AssertionError as noticed:
            print("noticed:", noticed)
        else:
            check(False, f"the damage '{expected}' went unnoticed")


def main():
    arguments = [a for a in sys.argv[1:] if a != "--control"]
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not program:
        print("skipped: no Chromium is installed (Debian: chromium)")
        return SKIPPED
    folder = arguments[1]
    subprocess.run([arguments[0], folder], check=True)
    page = folder + "/report.html"
    with open(folder + "/report.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if "--control" in sys.argv:
        controls(program, page, rows)
    else:
        check_page(program, page, rows, arguments[3] if "--screenshot" in arguments else None)
    print("passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
