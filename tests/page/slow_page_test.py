#!/usr/bin/env python3
"""The page on a slow device: Chromium with a main thread that is throttled, on a tall screen and on a wide one. From the first picture
on, sand is seen in the glass and none beside it, the glass turns by itself within 8 s and sand runs; a hitch, another tab and a screen that
is turned lose none. Pixels are counted as they were drawn: of sand are those that differ when it is left out; of the glass those
that its mesh covers. How much sand must be seen is told by the same scene with all its work: the same particles, the same screen. The
controls, a glass that is drawn by a pose 0.1 of a turn ahead, and a page that bakes a field in its module before the first picture, must fail.

slow_page_test.py WEB_SCENE NPM_FOLDER WORK_FOLDER [--full]     --full: all throttles, and one core beside a busy loop
Exit code 77: there is no Chromium here."""

import os
import pathlib
import statistics
import subprocess
import sys
import time

import browser as driver
from browser import CHROMIUM, SKIPPED, Browser, check
from live_page import assemble, set_budget, wait_until

TALL, WIDE = (390, 844), (844, 390)
SHORT = [(1, TALL, False), (6, WIDE, False)]
FULL = [(rate, size, False) for rate in (1, 4, 6, 20) for size in (TALL, WIDE)] + [(1, TALL, True)]
FIRST = {1: 2, 4: 2, 6: 5, 20: 5}  # seconds until the first picture
LOADS = 3  # of whose first pictures the middle one counts
FIRST_SAND = 0.1  # of the glass, in them
TURNED = 8  # seconds after it until the glass has turned and sand runs
NEAR = 2  # pixels that an edge of sand may be beside the glass
SEEN = 0.75  # of the sand's share of the glass, with all work, at least
BESIDE = 0.01  # of the sand at most: ends of lines, where a grain falls along the wall

# Takes pictures: `moments` seconds after the first one, and where `seen.now` was set. Without moments the first one stays.
WATCH = """(moments) => {
  const seen = window.seen = { shots: [] };
  let made;
  const watch = (page) => {
    const { painter } = page, { gl, canvas } = painter, draw = page.draw.bind(page);
    seen.pixels = () => { const out = new Uint8Array(4 * canvas.width * canvas.height); gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, out); return out; };
    seen.shoot = () => {
      painter.sand.draw = () => {}, draw();
      const bare = seen.pixels();
      delete painter.sand.draw, draw();
      return { at: performance.now() - seen.first, size: [canvas.width, canvas.height], screen: [canvas.clientWidth, canvas.clientHeight], model: [...painter.glass.model], share: page.turning.share,
        camera: { ...page.camera }, pixels: page.pace.now.pixels, sand: seen.pixels(), bare };
    };
    page.draw = () => {
      draw();
      if (!seen.first) gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)), seen.first = performance.now(), page.measuring = moments === null;
      const due = moments?.length > 0 && performance.now() - seen.first >= 1e3 * moments[0];
      if (!page.onTable && (due || seen.now)) seen.shots.push(seen.shoot()), due && moments.shift(), seen.now = false;
    };
  };
  Object.defineProperty(window, "sandglassPage", { get: () => made, set: (value) => { made = value, watch(value.page); } });
}"""
# Of a picture: pixels of the glass, of sand in it, beside it and below its neck; of the whole at the picture's rim.
COUNT = """(({ at, size: [w, h], model, share, camera: given, pixels, sand, bare }, ahead = model) => {
  const { page } = sandglassPage, { painter } = page, { canvas } = painter, { objects, glass } = painter, camera = Object.assign(Object.create(Object.getPrototypeOf(page.camera)), given);
  const differ = (a, b) => Uint8Array.from({ length: w * h }, (_, i) => a[4 * i] !== b[4 * i] || a[4 * i + 1] !== b[4 * i + 1] || a[4 * i + 2] !== b[4 * i + 2]);
  const drawn = (...items) => { painter.objects = items, painter.draw(camera, { pixels, smooth: false }); return seen.pixels(); };
  painter.glass = null, painter.sand.draw = () => {};
  const solid = { ...glass, model: ahead, albedo: [1, 0, 0], table: 0, metal: 0 }, empty = drawn(), inside = differ(drawn(solid), empty), whole = differ(drawn(solid, { ...objects[0], model: ahead }), empty);
  painter.glass = glass, painter.objects = objects, delete painter.sand.draw;
  if (canvas.width !== w || canvas.height !== h) throw new Error(`the picture was ${w} x ${h}, and is ${canvas.width} x ${canvas.height}`);
  const grain = differ(sand, bare), out = { at: Math.round(at), size: [w, h], share, glass: 0, sand: 0, beside: 0, below: 0, rim: 0 }, { eye, up, away } = camera.axes();
  const dot = (a) => a.reduce((sum, x, i) => sum + x * (model[12 + i] - eye[i]), 0), neck = (0.5 - 0.5 * dot(up) / dot(away) / camera.half(w / h)[1]) * h;
  for (let y = 0, i = 0; y < h; ++y) for (let x = 0; x < w; ++x, ++i) {
    out.glass += inside[i], out.rim += whole[i] && (x === 0 || y === 0 || x === w - 1 || y === h - 1);
    if (!grain[i]) continue;
    let near = false;
    for (let b = -NEAR; b <= NEAR; ++b) for (let a = -NEAR; a <= NEAR; ++a) near ||= x + a >= 0 && x + a < w && inside[(y + b) * w + x + a] > 0;
    near ? ++out.sand : ++out.beside;
    if (y < neck) ++out.below;
  }
  return out;
})""".replace("NEAR", str(NEAR))


def crowded():
    """How many times longer work takes here because of others than by itself."""
    wall, own = time.monotonic(), time.process_time()
    while time.process_time() - own < 0.3:
        pass
    return max(1.0, (time.monotonic() - wall) / 0.3)


def counts_of(browser, shots="seen.shots"):
    return browser.ask(f"{shots}.map((shot) => {COUNT}(shot))")


def complain(shot, least, what):
    """What is wrong with a picture."""
    if shot["sand"] < SEEN * least * shot["glass"]:
        return f"{what}: of {shot['glass']} pixels of the glass {shot['sand']} show sand"
    if shot["beside"] > BESIDE * shot["sand"]:
        return f"{what}: {shot['beside']} pixels of sand are beside the glass, {shot['sand']} in it"
    return f"{what}: the glass is cut off" if shot["rim"] > 0 else None


def with_all_work(browser):
    """The same scene with all its work, over one turn: the least share of the glass that shows sand. The control fails here."""
    browser.ask(
        "(() => { const { page } = sandglassPage; page.measuring = true, page.again(), document.getElementById('budget').max = 1e4; })()"
    )
    set_budget(browser, 1e4)
    shots = browser.ask(f"""(() => {{ const {{ page }} = sandglassPage, shots = [];
        page.turnOver();
        for (let k = 0; k < 12; ++k) {{
          shots.push({COUNT}(seen.shoot()));
          for (let i = 0; i < 8; ++i) page.advance(1 / 60 + 1e-9);
        }}
        return shots; }})()""")
    for shot in shots:
        check(not complain(shot, 0, ""), f"with all work{complain(shot, 0, '')}: {shot}")
    check(shots[-1]["share"] == 1, f"96 frames do not turn it: {shots[-1]}")
    ahead = browser.ask(f"""(() => {{ const {{ page }} = sandglassPage;
        page.again(), page.turnOver();
        for (let i = 0; i < 30; ++i) page.advance(1 / 60 + 1e-9);
        const shot = seen.shoot(), {{ turning }} = page, before = turning.share;
        turning.share = before + 0.1, page.placeGlass();
        const ahead = [...page.painter.glass.model];
        turning.share = before, page.placeGlass();
        return {COUNT}(shot, ahead); }})()""")
    check(ahead["beside"] > BESIDE * ahead["sand"], f"the control, a glass that is ahead of its sand, passes: {ahead}")
    set_budget(browser, 8)
    return min(shot["sand"] / shot["glass"] for shot in shots)


def disturbed(browser, size):
    """While it turns: half a second without a frame, another tab for a second, and a screen that is turned."""
    browser.ask("seen.shots = [], sandglassPage.page.again(), sandglassPage.page.turnOver()")
    taken = "(seen.now = true, new Promise((done) => { const look = () => { sandglassPage.page.wake(); if (seen.now) setTimeout(look, 20); else done(); }; look(); }))"
    hitch = "(() => { const since = performance.now(); while (performance.now() - since < 500); })()"
    for _ in range(2):
        browser.ask(taken)
        browser.ask(hitch)
    browser.ask(taken)
    own = next(t for t in browser.call("Target.getTargets")["targetInfos"] if t["type"] == "page")["targetId"]
    other = browser.call("Target.createTarget", url="about:blank")["targetId"]
    wait_until(browser, "document.visibilityState === 'hidden'")
    before = browser.ask("sandglassPage.page.turning.share")
    time.sleep(1)
    check(browser.ask("sandglassPage.page.turning.share") == before, "it turns while it is hidden")
    browser.call("Target.activateTarget", targetId=own)
    browser.call("Target.closeTarget", targetId=other)
    browser.ask(taken)
    shots = counts_of(browser)
    browser.call("Emulation.setDeviceMetricsOverride", width=size[1], height=size[0], deviceScaleFactor=1, mobile=False)
    browser.ask("seen.shots = []")
    wait_until(browser, f"innerWidth === {size[1]}")
    browser.ask(taken)
    turned = counts_of(browser)
    check((turned[-1]["size"][0] > turned[-1]["size"][1]) == (size[1] > size[0]), f"on a turned screen the picture is {turned[-1]['size']}")
    return shots + turned


def run(page, rate, size, one_core, moments, work):
    factor, cores, busy = crowded() * (2 if one_core else 1), os.sched_getaffinity(0), None
    if one_core:
        os.sched_setaffinity(0, {min(cores)})
        busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    name, problems = f"{size[0]} x {size[1]}, throttled {rate} times{', one core' if one_core else ''}", []
    browser = Browser(CHROMIUM, *size)
    try:
        browser.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)
        browser.call("Page.addScriptToEvaluateOnNewDocument", source=f"({WATCH})({[moment * factor for moment in moments]})")
        browser.call("Emulation.setCPUThrottlingRate", rate=rate)
        browser.open(page)
        wait_until(
            browser, f"!!window.sandglassPage && (sandglassPage.page.wake(), seen.shots.length === {len(moments)})"
        )  # sand may lie still
        said = browser.ask("document.getElementById('short').textContent")
        browser.screenshot(work / f"slow_{size[0]}_{rate}{'_one' if one_core else ''}.png")
        browser.call("Emulation.setCPUThrottlingRate", rate=1)
        if busy:
            busy.kill()
        browser.ask("sandglassPage.page.measuring = true")
        shots, first = counts_of(browser), browser.ask("seen.first / 1e3")
        least = with_all_work(browser)
        browser.ask("sandglassPage.page.measuring = false")
        browser.call("Emulation.setCPUThrottlingRate", rate=rate)
        after = disturbed(browser, size)
        print(
            f'{name}: first picture after {first:.1f} s, others take {factor:.1f} times; it says "{said}"; with all work sand is on {least:.2f} of the glass or more'
        )
        for shot in shots + after:
            print("  ", shot)
        problems += [complain(shot, least, f"{name}, after {shot['at'] / 1e3:.1f} s") for shot in shots + after]
        if first > FIRST[rate] * factor:
            problems.append(f"{name}: the first picture comes after {first:.1f} s")
        late = shots[moments.index(TURNED)]
        if late["share"] < 1 or late["below"] == 0:
            problems.append(f"{name}: it has not turned and run: {late}")
        if rate >= 20 and "slow" not in said and "busy" not in said:
            problems.append(f"{name}: it says nothing of that: {said}")
        return [problem for problem in problems if problem]
    finally:
        browser.close()
        if busy:
            busy.kill()
            busy.wait()
        os.sched_setaffinity(0, cores)


def load(page, rate):
    """Seconds until the first picture, those that the page's own thread worked until then, and what is seen in it."""
    browser = Browser(CHROMIUM, *TALL)
    try:
        browser.call("Performance.enable")
        browser.call("Emulation.setDeviceMetricsOverride", width=TALL[0], height=TALL[1], deviceScaleFactor=1, mobile=False)
        browser.call("Page.addScriptToEvaluateOnNewDocument", source=f"({WATCH})(null)")
        browser.call("Emulation.setCPUThrottlingRate", rate=rate)
        browser.open(page)
        wait_until(browser, "!!window.seen?.first")
        worked = next(one["value"] for one in browser.call("Performance.getMetrics")["metrics"] if one["name"] == "ThreadTime")
        browser.call("Emulation.setCPUThrottlingRate", rate=1)
        return browser.ask("seen.first / 1e3"), worked, counts_of(browser, "[seen.shoot()]")[0]
    finally:
        browser.close()


def changed(page, name, old, new):
    text = page.read_text()
    check(text.count(old) == 1, f"the page has not one {old!r}")
    page.with_name(name).write_text(text.replace(old, new))
    return page.with_name(name)


def first_pictures(page):
    """Sand is seen in the first picture, in time. What others do here makes it late, so the time of the page's own thread counts, too."""
    problems = []
    for rate in (1, 4, 20):
        before, loads = crowded(), [load(page, rate) for _ in range(LOADS)]
        first, factor = statistics.median(seconds for seconds, _, _ in loads), max(before, crowded())
        print(f"throttled {rate} times, first picture after {first:.2f} s, others take {factor:.1f} times: {loads[0][2]}")
        problems += [complain(shot, FIRST_SAND / SEEN, f"first picture, throttled {rate} times") for _, _, shot in loads]
        if first > FIRST[rate] * factor:
            problems.append(f"throttled {rate} times, the first picture comes after {first:.1f} s")
    slow = changed(page, "slow.html", "k_quick_ms = 120", "k_quick_ms = 0")  # as on a device that takes longer
    makes = "  const page = new Page("
    baked = changed(slow, "baked.html", makes, f"  k_scene.colliders.forEach(({{ field }}) => field && fieldBytes(sand, field));\n{makes}")
    work, control = (20 * statistics.median(load(one, 1)[1] for _ in range(LOADS)) for one in (slow, baked))
    print(f"20 times the work until the first picture: {work:.2f} s; with a bake in the module {control:.2f} s")
    if work > FIRST[20]:
        problems.append(f"20 times the work until the first picture is {work:.1f} s")
    check(control > FIRST[20], f"the control, a bake in the module, passes: {control:.1f} s")
    return [problem for problem in problems if problem]


def main():
    web_scene, npm, work = sys.argv[1:4]
    if not CHROMIUM:
        print("no chromium")
        return SKIPPED
    work = pathlib.Path(work).resolve()
    work.mkdir(parents=True, exist_ok=True)
    page, full = assemble(web_scene, npm, work), "--full" in sys.argv
    driver.PATIENCE = 240
    problems = first_pictures(page)
    for rate, size, one_core in FULL if full else SHORT:
        problems += run(page, rate, size, one_core, [0, 1, 2, 4, TURNED, 16] if full else [0, 1, 2, 4, TURNED], work)
    check(not problems, "; ".join(problems))
    return 0


if __name__ == "__main__":
    sys.exit(main())
