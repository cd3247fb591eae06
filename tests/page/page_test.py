#!/usr/bin/env python3
"""The report's page in headless Chromium: it opens from its file without a complaint and without another request, its bars are
the numbers of the CSV, what is over the budget is marked, pointing at a bar reads it, its sliders follow mouse and keys.

page_test.py FIXTURE FOLDER                         FIXTURE writes FOLDER/report.html and FOLDER/report.csv
page_test.py --control FIXTURE FOLDER               damages the page in three ways, each of which the checks must notice
Exit code 77: there is no Chromium here."""

import csv
import subprocess
import sys

from browser import CHROMIUM, SKIPPED, Browser, check

HALF_PIXEL = 0.5


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
    """Heights of the bars times the chart's scale, against the CSV, stage by stage."""
    bars = browser.ask("""[...document.querySelectorAll('#timeline rect[data-frame]')].map(r =>
        [+r.dataset.frame, r.dataset.stage, +r.getAttribute('height') * r.ownerSVGElement.dataset.msPerPixel])""")
    scale = browser.ask("+document.querySelector('#timeline').dataset.msPerPixel")
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
        got = drawn.get((frame, "between units"), 0.0)
        check(abs(got - between) <= HALF_PIXEL * scale, f"frame {frame}: {got} ms between units for {between} ms")
    check(len(bars) >= total, "bars are missing")
    missed = [int(r["frame"]) for r in rows if float(r["elapsed_ms"]) > float(r["budget_ms"])]
    marked = browser.ask("[...document.querySelectorAll('#timeline .miss')].map(m => +m.dataset.frame)")
    check(marked == missed and missed, f"marked as missed {marked}, missed {missed}")


def check_the_rest(browser, rows):
    levels = browser.ask("[...document.querySelectorAll('#timeline rect[data-level]')].map(r => +r.dataset.level)")
    check(levels == [int(row["level"]) for row in rows], f"quality is drawn as {levels}")
    legend = browser.ask("[...document.querySelectorAll('#levels li')].map(l => l.textContent)")
    check(len(legend) == len(set(levels)) and legend[0] == "level 0 (full): 60 of 120 frames", f"the levels are {legend}")
    text = browser.ask("document.body.innerText")
    for word in ('known <run> & "page"', "</script> is text.", "0x<7>", "budget used", "45 of 120 frames over it"):
        check(word in text, f"'{word}' is not on the page")
    row = rows[-1]
    bar = f"""document.querySelector('#timeline rect[data-frame="{row["frame"]}"]').parentElement"""
    read = browser.ask(f"{bar}.querySelector('title').textContent")
    for word in (
        f"frame {row['frame']}: {float(row['elapsed_ms']):.3f} of 4 ms",
        f"shadow {float(row['shadow_ms']):.3f} ms, {row['shadow_units']} units",
    ):
        check(word in read, f"pointing at a bar says: {read}")
    unnamed = browser.ask("""[...document.querySelectorAll('svg, img, input')].filter(e =>
        !(e.getAttribute('aria-label') || e.alt)).length""")
    check(unnamed == 0, f"{unnamed} elements have no name for a screen reader")


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
    browser.open(folder + "/empty.html")
    wait_until_drawn(browser)
    check(browser.ask("document.querySelectorAll('#timeline rect[data-frame]').length") == 0, "an empty run has bars")
    odd = browser.ask(
        "[...document.querySelectorAll('svg *')].filter(e => [...e.attributes].some(a => /NaN|Infinity/.test(a.value))).length"
    )
    check(odd == 0, f"{odd} shapes of the empty run have no place")


def check_page(page, rows):
    browser = Browser(CHROMIUM)
    try:
        browser.open(page)
        wait_until_drawn(browser)
        check_opens(browser, page)
        check_bars(browser, rows)
        check_the_rest(browser, rows)
        check_slider(browser)
        check_widths(browser)
        check_extremes(browser, page.rsplit("/", 1)[0])
        check(not browser.complaints, f"the console complains: {browser.complaints}")
    finally:
        browser.close()


def controls(page, rows):
    text = open(page, encoding="utf-8").read()
    damages = {
        "a bar of": text.replace("y(from + ms)", "y(from + 1.1 * ms)"),
        "the slider": text.replace("addEventListener('input'", "addEventListener('no'"),
        "console complains": text.replace(
            "document.documentElement.dataset.drawn", "console.error('no'); document.documentElement.dataset.drawn"
        ),
    }
    for expected, damaged in damages.items():
        check(damaged != text, f"the control '{expected}' changes nothing")
        with open(page, "w", encoding="utf-8") as file:
            file.write(damaged)
        try:
            check_page(page, rows)
        except AssertionError as noticed:
            check(expected in str(noticed), f"the damage '{expected}' is noticed as: {noticed}")
            print("noticed:", noticed)
        else:
            check(False, f"the damage '{expected}' went unnoticed")


def main():
    arguments = [a for a in sys.argv[1:] if a != "--control"]
    if not CHROMIUM:
        print("skipped: no Chromium is installed (Debian: chromium)")
        return SKIPPED
    folder = arguments[1]
    subprocess.run([arguments[0], folder], check=True)
    page = folder + "/report.html"
    with open(folder + "/report.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    (controls if "--control" in sys.argv else check_page)(page, rows)
    print("passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
