#!/usr/bin/env python3
"""sandglass/react: its example is short and has types; under StrictMode two canvases show sand; a scene drawn on demand is drawn while
something changes; unmounted, nothing is left.

react_test.py NPM_FOLDER WORK_FOLDER [--hot]    WORK_FOLDER has node_modules. --hot: as Vite serves it, and while its example is edited.
Exit code 77: there is no Chromium here."""

import pathlib
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "page"))
from browser import CHROMIUM, SKIPPED, SOFTWARE, Browser, served
from engines_test import vite

HERE = pathlib.Path(__file__).parent / "react"
PATIENCE = 60
BENIGN = "ReadPixels", "THREE.Clock", "Context Lost"
STRICT = "--noEmit --strict --jsx react-jsx --module esnext --moduleResolution bundler --target es2022 --skipLibCheck".split()
VITE = "import react from '@vitejs/plugin-react';\nexport default { plugins: [react()], optimizeDeps: { entries: 'react.html' } };\n"
# By React's rules the first keeps what is mounted, and the second mounts it anew.
EDITS = {
    "an edit": {"</Sandglass>": '</Sandglass>\n    <group name="edited" />'},
    "an edit of hooks": {"export": 'import { useState } from "react";\nexport', "=> (": "=> useState(1)[0] && ("},
}
BUNDLE = "--bundle --format=esm --jsx=automatic --splitting --outdir=react --log-level=error".split()
PAGE = '<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><body style="margin:0"></body><script type="module" src="react_main.js"></script>'
# Of a scene: pictures drawn so far; its particles; what stands in it.
PICTURES, PARTICLES = "found.demand.gl.info.render.frame", "found.demand.stage.drawn.particles"
KINDS = "found.demand.scene.children.map((one) => one.type).sort().join()"
# What stands for places, and how high it reaches.
PLACES = "found.demand.scene.children.filter((one) => one.children[0]?.material?.colorWrite === false)"
TOP = f"({PLACES}.at(-1)?.children[0].geometry.getAttribute('position').array.reduce((a, y, i) => (i % 3 === 1 ? Math.max(a, y) : a), -9))"
# How many of the pixels of a canvas are as sand is: red over blue, unlike floor and cube.
SAND = """((canvas) => {
  const flat = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height }).getContext("2d");
  flat.drawImage(canvas, 0, 0);
  const { data } = flat.getImageData(0, 0, canvas.width, canvas.height);
  let found = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 0 && data[i] - data[i + 2] > 15) ++found;
  return found;
})"""


def check(right, sentence):
    print(("" if right else "WRONG: ") + sentence, flush=True)
    if not right:
        sys.exit(1)


def until(browser, condition, sentence):
    end = time.monotonic() + PATIENCE
    while not (right := browser.ask(condition)) and time.monotonic() < end:
        time.sleep(0.1)
    check(right, sentence)


def complains_of_nothing(browser):
    told = [text for text in browser.complaints if not any(one in text for one in BENIGN)]
    check(not told, f"the page complains of nothing: {told[:3]}")


def still(browser):
    """Pictures that are drawn in a second, at last."""
    for _ in range(15):
        before = browser.ask(PICTURES)
        time.sleep(1)
        if (more := browser.ask(PICTURES) - before) == 0:
            break
    return more


def prepare(npm, work):
    shutil.rmtree(work / "node_modules/sandglass", ignore_errors=True)
    shutil.copytree(npm, work / "node_modules/sandglass")
    for name in ("example", "main"):
        shutil.copy(HERE / f"{name}.tsx", work / f"react_{name}.tsx" if name == "main" else work / f"{name}.tsx")
    shutil.copy(HERE / "things.ts", work)
    lines = len((HERE / "example.tsx").read_text().splitlines())
    check(lines <= 20, f"the example has {lines} lines, with its imports")
    subprocess.run(["node_modules/.bin/tsc", *STRICT, "react_main.tsx", "example.tsx"], cwd=work, check=True, timeout=300)
    subprocess.run(["node_modules/.bin/esbuild", "react_main.tsx", *BUNDLE], cwd=work, check=True, timeout=300)
    shutil.copy(npm / "sandglass.wasm", work / "react")
    (work / "react/index.html").write_text(PAGE)


def hot(work, url):
    """After each edit there are as many stages, workers and canvases as before, sand is seen, and the page is the same."""
    browser = Browser(CHROMIUM, width=500, height=760, flags=SOFTWARE)
    example = work / "example.tsx"
    seen = " && ".join(f"looked({k}, {SAND}) > 100" for k in range(2))
    try:
        browser.open(url)
        until(browser, "globalThis.ready === 'yes' && !!globalThis.found.demand", "by Vite's server stages are there")
        until(browser, seen, "and show sand")
        scenes, workers = browser.ask("scenes()"), browser.ask("workers")
        browser.ask("globalThis.before = [...document.querySelectorAll('canvas')].slice(0, 2); 0")
        for name, changes in EDITS.items():
            text = example.read_text()
            for old, new in changes.items():
                text = text.replace(old, new, 1)
            example.write_text(text)
            mounted = "!==" if "hooks" in name else "==="
            taken = f"before.every((one, k) => scenes()[k]?.includes('edited') && document.querySelectorAll('canvas')[k] {mounted} one)"
            until(browser, taken, f"{name} is taken")
            until(browser, seen, f"after {name} sand is seen")
            until(browser, f"workers === {workers}", f"after {name} there are {workers} workers, as before")
            now = [scene.replace(",edited", "") for scene in browser.ask("scenes()")]
            check(now == scenes, f"after {name} the scenes hold {now}")
        complains_of_nothing(browser)
    finally:
        browser.close()


def main(arguments):
    if CHROMIUM is None:
        return SKIPPED
    npm, work = map(pathlib.Path, arguments[:2])
    prepare(npm, work)
    if arguments[2:] == ["--hot"]:
        (work / "react.html").write_text(PAGE.replace("react_main.js", "/react_main.tsx"))
        (work / "react.config.mjs").write_text(VITE)
        vite(work, lambda url: hot(work, url), "react.html", ("--config", "react.config.mjs"))
        return 0
    browser = Browser(CHROMIUM, width=500, height=760, flags=SOFTWARE)
    try:
        browser.open(served(work / "react") + "index.html")
        until(browser, "globalThis.ready === 'yes' && !!globalThis.found.demand", "stages are there")
        for k in range(2):
            until(browser, f"looked({k}, {SAND}) > 100", f"canvas {k} shows sand")
        browser.screenshot(work / "react/picture.png")
        check(still(browser) == 0, "on demand nothing is drawn while nothing changes")
        browser.ask("show({ pour: true })")
        until(browser, f"{PARTICLES} > 200", "on demand sand is poured")
        browser.ask("show({ pour: false })")
        check(still(browser) == 0, "and nothing is drawn once it lies")
        kinds = browser.ask(KINDS)
        check(kinds == "DirectionalLight,Group,LightProbe,Object3D", f"the scene holds one stage: {kinds}")
        for table in (1, 2):
            browser.ask(f"show({{ table: {table} }})")
            until(browser, f"Math.abs({TOP} - {0.05 * table}) < 1e-6", f"a place stands there, half of {0.1 * table:.1f} m high")
        check(browser.ask(f"{PLACES}.length") == 1, "and no other")
        browser.ask("show({ table: 0 })")
        until(browser, f"{PLACES}.length === 0", "and is withdrawn")
        check(browser.ask("hand()") == 25, "hands are asked of a session's frame")
        browser.ask("show({ shown: false })")
        until(browser, f"{KINDS} === ''", "unmounted, nothing is left in the scene")
        browser.ask("leave()")
        until(browser, "workers === 1", "unmounted, the workers of stages have ended; the one that makes fields is kept")
        complains_of_nothing(browser)
    finally:
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
