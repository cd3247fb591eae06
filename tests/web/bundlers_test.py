#!/usr/bin/env python3
"""sandglass/react as webpack bundles it, and on a page of Next.js, rendered by its server first: canvases show sand, nothing complains.

bundlers_test.py NPM_FOLDER WORK_FOLDER    WORK_FOLDER has node_modules. Exit code 77: there is no Chromium here."""

import os
import pathlib
import shutil
import subprocess
import sys

import react_test
from react_test import CHROMIUM, PAGE, SAND, SKIPPED, SOFTWARE, Browser, check, complains_of_nothing, served, until

HERE = pathlib.Path(__file__).parent / "bundlers"
INSTALL = "npm ci --ignore-scripts --legacy-peer-deps --no-audit --no-fund --loglevel error".split()
MODULES = "--format=esm --jsx=automatic --outdir=bundlers/js --log-level=error".split()
# As long as the picture of a frame is there.
LOOKED = "new Promise((seen) => requestAnimationFrame(() => seen(%s(document.querySelectorAll('canvas')[%d]) > 100)))"


def run(command, folder, **more):
    subprocess.run(command, cwd=folder, check=True, timeout=600, env={**os.environ, "NEXT_TELEMETRY_DISABLED": "1"}, **more)


def look(folder, canvases, name):
    browser = Browser(CHROMIUM, width=500, height=760, flags=SOFTWARE)
    try:
        browser.open(served(folder) + "index.html")
        for k in range(canvases):
            until(browser, f"document.querySelectorAll('canvas').length > {k}", f"by {name} there is a canvas {k}")
            until(browser, LOOKED % (SAND, k), "and it shows sand")
        if canvases == 2:
            check(not browser.ask(LOOKED % (SAND, 2)), "where nothing is poured there is none")
        browser.screenshot(folder / "picture.png")
        complains_of_nothing(browser)
    finally:
        browser.close()


def main(arguments):
    if CHROMIUM is None:
        return SKIPPED
    npm, work = (pathlib.Path(one).resolve() for one in arguments)
    folder = work / "bundlers"
    shutil.rmtree(folder / "app", ignore_errors=True)
    shutil.copytree(HERE, folder, dirs_exist_ok=True)
    run(INSTALL, folder)
    react_test.prepare(npm, work)
    run(["node_modules/.bin/esbuild", "react_main.tsx", "example.tsx", "things.ts", *MODULES], work)
    run(["node", "webpack.mjs"], folder)
    (folder / "webpack/index.html").write_text(PAGE)
    look(folder / "webpack", 2, "webpack")
    (folder / "app").mkdir()
    for name in ("page.tsx", "layout.tsx"):
        shutil.move(folder / name, folder / "app" / name)
    for name in ("example.tsx", "things.ts"):
        shutil.copy(work / name, folder)
    for bundler in ("--turbopack", "--webpack"):
        shutil.rmtree(folder / "out", ignore_errors=True)
        run(["node_modules/.bin/next", "build", bundler], folder, stdout=subprocess.DEVNULL)
        look(folder / "out", 1, "Next.js " + bundler)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
