#!/usr/bin/env python3
"""The live page in headless Chromium: it opens from its file without a complaint and without another request, sand falls, a finger
pours and pushes, the fixed run ends in the hash of the program, a recording plays to the bit, a mesh becomes sand, a wrong file is answered with one sentence, and
memory does not grow.

live_page_test.py WEB_SCENE SANDGLASS NPM_FOLDER WORK_FOLDER [--screenshots]
Exit code 77: there is no Chromium here, or no program to compare with."""
import os
import pathlib
import shutil
import subprocess
import sys
import time

import browser as driver
from browser import Browser

SKIPPED = 77
ROOT = pathlib.Path(__file__).resolve().parents[2]
FRAMES = 300
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0.5 0 0.9\nv 0.5 0.9 0.3\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n"
OF_THE_MACHINE = ("fallback to software WebGL", "GPU stall due to ReadPixels")  # there is no GPU, and screenshots are read back
BAD_FILES = {"a.obj": "v 0 0 0\nf 1 2 3\n", "b.obj": "v 0 zero 0\n", "c.obj": "", "d.gltf": "{}", "e.json": "{", "f.json": '{"sandglass": "recording"}', "flat.obj": "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"}


def check(condition, sentence):
    if not condition:
        raise AssertionError(sentence)


def wait_until(browser, expression, patience=240):
    end = time.monotonic() + patience
    while not browser.ask(expression):
        check(time.monotonic() < end, f"never true: {expression}")
        time.sleep(0.3)


def native_hash(sandglass):
    out = subprocess.run([sandglass, "run", str(ROOT / "models/page/page.json"), "--frames", str(FRAMES), "--clock", "virtual", "--budget-ms",
                          "100000"], check=True, capture_output=True, text=True).stdout
    return next(line.split()[1] for line in out.splitlines() if line.startswith("hash "))


def assemble(web_scene, npm, work):
    scene, page = work / "page.json", work / "sandglass.html"
    subprocess.run([web_scene, ROOT / "models/page/page.json", scene], check=True)
    subprocess.run([sys.executable, ROOT / "models/page/assemble.py", npm, scene, ROOT / "models/shadows/chair.shadow", page], check=True)
    return page


def drop(browser, name, text):
    browser.ask(f"""(() => {{ const data = new DataTransfer(); data.items.add(new File([{text!r}], {name!r}));
        document.getElementById('says').textContent = '';
        dispatchEvent(new DragEvent('drop', {{dataTransfer: data, bubbles: true, cancelable: true}})); }})()""")
    wait_until(browser, "document.getElementById('says').textContent !== ''")
    return browser.ask("document.getElementById('says').textContent")


def report(browser, field):
    return browser.ask(f"sandglassPage.page.scene.report.{field}")


def check_pours(browser, page):
    """Where the finger is, there are more grains afterwards than before."""
    browser.ask("sandglassPage.page.again()")
    near = """(() => {{ const {{page}} = sandglassPage, n = page.scene.report.grain_numbers, g = page.sand.floats(page.scene.grains, 4 * n);
        let count = 0;
        for (let i = 0; i < n; ++i) count += g[4 * i + 3] >= 0 && Math.hypot(g[4 * i] - {0}, g[4 * i + 2] - {1}) < 0.06;
        return count; }})()"""
    box = browser.ask("(() => { const b = document.getElementById('view').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()")
    x, y = box[0] + 0.72 * box[2], box[1] + 0.75 * box[3]
    at = browser.ask(f"sandglassPage.page.place({{clientX: {x}, clientY: {y}}})")
    before = browser.ask(near.format(at[0], at[2]))
    browser.mouse("mouseMoved", x, y)
    browser.mouse("mousePressed", x, y, "left", 1)
    wait_until(browser, near.format(at[0], at[2]) + f" > {before} + 300")
    browser.mouse("mouseReleased", x, y, "left")
    check(browser.ask("sandglassPage.page.at") is None, "the finger still pours after it was lifted")
    return at


def check_pushes(browser, at):
    """The hand that a finger moves into the sand drives it out of its way."""
    browser.ask("document.querySelector('[value=push]').click()")
    browser.ask(f"sandglassPage.page.at = [{at[0]} + 0.08, 0, {at[2]}]")
    wait_until(browser, "sandglassPage.page.pushing !== null")
    browser.ask(f"sandglassPage.page.at = [{at[0]}, 0, {at[2]}]")
    wait_until(browser, f"Math.hypot(sandglassPage.page.pushing[0] - {at[0]}, sandglassPage.page.pushing[2] - {at[2]}) < 0.01")
    wait_until(browser, f"""(() => {{ const {{page}} = sandglassPage, n = page.scene.report.grain_numbers, g = page.sand.floats(page.scene.grains, 4 * n),
        p = page.pushing; let count = 0;
        for (let i = 0; i < n; ++i) count += g[4 * i + 3] >= 0 && Math.hypot(g[4 * i] - p[0], g[4 * i + 1] - p[1], g[4 * i + 2] - p[2]) < 0.03;
        return count; }})() === 0""")
    browser.ask("sandglassPage.page.at = null")
    browser.ask("document.querySelector('[value=pour]').click()")


def check_keyboard(browser):
    browser.ask("document.getElementById('view').focus()")
    browser.key("ArrowRight", 39)
    check("cm right" in browser.ask("document.getElementById('says').textContent"), "the arrow key says nothing")
    poured = "sandglassPage.page.at !== null"
    browser.call("Input.dispatchKeyEvent", type="keyDown", key=" ", code="Space", windowsVirtualKeyCode=32)
    check(browser.ask(poured), "the space bar does not pour")
    browser.call("Input.dispatchKeyEvent", type="keyUp", key=" ", code="Space", windowsVirtualKeyCode=32)
    check(not browser.ask(poured), "it pours after the key was lifted")
    unnamed = browser.ask("""[...document.querySelectorAll('button, input, canvas')].filter(e => !(e.ariaLabel || e.textContent.trim() ||
        e.labels?.length || e.getAttribute('aria-labelledby'))).map(e => e.id)""")
    check(not unnamed, f"without a name for a screen reader: {unnamed}")


def check_memory(browser):
    bytes_of = "sandglassPage.page.sand.memory.buffer.byteLength"
    before, first = browser.ask(bytes_of), browser.ask("sandglassPage.page.scene.frames")
    wait_until(browser, f"sandglassPage.page.scene.frames > {first} + 60")
    check(browser.ask(bytes_of) == before, "the module's memory grows")


def check_recording(browser):
    """What was poured, pushed and dropped so far, under budgets that did not suffice, ends in the same hash when it is played."""
    browser.ask("document.getElementById('save').click()")
    check(browser.ask("document.getElementById('says').textContent").startswith("Saved"), "nothing was saved")
    browser.ask("sandglassPage.page.measuring = true")
    browser.ask("window.recording = sandglassPage.page.recording()")
    frames, added = browser.ask("[recording.frames.length, recording.frames.filter(f => f.added).length]")
    check(frames > 60 and added == 1, f"{frames} frames were recorded, and sand was added {added} times")
    browser.ask("void sandglassPage.page.play(recording, () => 0).then(h => { window.played = h; }, e => { window.played = e.message; })")
    wait_until(browser, "window.played", 900)
    check(browser.ask("window.played === recording.hash"), browser.ask("window.played"))
    memory = browser.ask("sandglassPage.page.sand.memory.buffer.byteLength")
    # The control: one frame less of pouring.
    browser.ask("recording.frames.find(f => f.emitters.length).emitters.pop(); window.played = 0")
    browser.ask("void sandglassPage.page.play(recording, () => 0).then(h => { window.played = h; }, e => { window.played = e.message; })")
    wait_until(browser, "window.played", 900)
    check(browser.ask("window.played !== recording.hash"), "another recording ends in the same hash")
    check(browser.ask("sandglassPage.page.sand.memory.buffer.byteLength") == memory, "what is played twice takes more memory")
    browser.ask("sandglassPage.page.measuring = false")


def check_narrow(browser):
    """At 360 pixels nothing lies beyond the edge, and everything can be reached."""
    browser.call("Emulation.setDeviceMetricsOverride", width=360, height=740, deviceScaleFactor=2, mobile=True)
    time.sleep(1)
    check(browser.ask("document.documentElement.scrollWidth") <= 360, "the page is wider than the screen")
    beyond = browser.ask("[...document.querySelectorAll('button, label, canvas')].filter(e => e.getBoundingClientRect().right > 361).map(e => e.textContent)")
    check(not beyond, f"beyond the edge: {beyond}")
    check(browser.ask("document.getElementById('view').clientHeight") > 250, "the table has no room")


def main():
    web_scene, sandglass, npm, work = sys.argv[1:5]
    program = shutil.which("chromium")
    if not program or not os.path.exists(sandglass):
        print("no chromium" if not program else f"no {sandglass}")
        return SKIPPED
    work = pathlib.Path(work)
    work.mkdir(parents=True, exist_ok=True)
    page = assemble(web_scene, npm, work)
    check(page.stat().st_size <= 3e6, "the page is larger than 3 MB")
    driver.PATIENCE = 240
    browser = Browser(program, 700, 620)  # it is drawn on the CPU
    try:
        browser.open(page)
        wait_until(browser, "document.documentElement.dataset.sand")
        print("first sand after", browser.ask("document.documentElement.dataset.sand"), "ms;", page.stat().st_size, "bytes")
        wait_until(browser, "sandglassPage.page.scene.report.particles > 300")
        check(report(browser, "clock_fault") == 0, "the browser's clock counts as broken")
        at = check_pours(browser, page)
        if "--screenshots" in sys.argv:
            time.sleep(5)
            browser.screenshot(work / "desktop.png")
        check_pushes(browser, at)
        check_keyboard(browser)
        check_memory(browser)
        for name, text in BAD_FILES.items():
            said = drop(browser, name, text)
            check(said.count(". ") == 1 and said.endswith("."), f"{name} is answered: {said}")
        before = report(browser, "particles")
        check("particles of" in drop(browser, "mesh.obj", TETRAHEDRON), "the mesh was not taken")
        wait_until(browser, f"sandglassPage.page.scene.report.particles > {before} + 200")
        check_recording(browser)
        check_narrow(browser)
        if "--screenshots" in sys.argv:
            browser.screenshot(work / "phone.png")
        browser.ask("sandglassPage.page.measuring = true")  # nothing is drawn meanwhile
        browser.ask(f"void sandglassPage.fixedRun({FRAMES}).then(r => {{ window.ran = r; }})")
        wait_until(browser, "window.ran", 900)
        ran, wanted = browser.ask("window.ran"), native_hash(sandglass)
        print("fixed run:", ran, "native", wanted)
        check(ran["isa"] == "wasm", f"the page runs {ran['isa']}")
        check(ran["hash"] == wanted, f"the page ends in {ran['hash']} and the program in {wanted}")
        complaints = [text for text in browser.complaints if not any(own in text for own in OF_THE_MACHINE)]
        check(not complaints, f"the console complains: {complaints}")
        others = [url for url in browser.requests if not url.startswith(("data:", "file://" + str(page)))]
        check(not others, f"the page asks for {others}")
    except Exception:
        print("page says:", browser.ask("document.getElementById('says').textContent"), browser.complaints)
        raise
    finally:
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
