#!/usr/bin/env python3
"""The live page in Firefox and in WebKitGTK, Safari's engine: it opens without a complaint, the hourglass turns, sand is poured and
drawn, and 90 frames end in the program's hash.

other_browsers_test.py WEB_SCENE SANDGLASS NPM_FOLDER WORK_FOLDER firefox|webkit
Runs under xvfb-run: without a screen Firefox has no WebGL 2. Exit code 77: the browser is not here."""

import glob
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

from browser import SKIPPED, check
from live_page import assemble, native_hash, wait_until

FRAMES, PATIENCE = 90, 300
PREFERENCES = {
    "webgl.force-enabled": True,
    "webgl.disable-fail-if-major-performance-caveat": True,
    "webgl.out-of-process": False,
    "gfx.x11-egl.force-enabled": True,
    "layers.acceleration.force-enabled": True,
}
SOFTWARE = {"LIBGL_ALWAYS_SOFTWARE": "1", "MOZ_X11_EGL": "1", "WEBKIT_DISABLE_SANDBOX_THIS_IS_DANGEROUS": "1"}
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": {**os.environ, **SOFTWARE}}


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def patiently(connect, name):
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return connect()
        except OSError:
            check(time.monotonic() < end, f"{name} does not answer")
            time.sleep(0.5)


class Firefox:
    """Over Marionette, its own protocol: a length, a colon, and JSON."""

    def __init__(self):
        self.profile, port = tempfile.mkdtemp(prefix="sandglass-page-"), free_port()
        pathlib.Path(self.profile, "user.js").write_text(
            "".join(f"user_pref({json.dumps(k)}, {json.dumps(v)});" for k, v in {**PREFERENCES, "marionette.port": port}.items())
        )
        self.process = subprocess.Popen(
            ["firefox-esr", "--marionette", "--profile", self.profile, "--width", "800", "--height", "900"], **QUIET
        )
        self.stream = patiently(lambda: socket.create_connection(("127.0.0.1", port), PATIENCE), "Firefox")
        self.buffer, self.number = b"", 0
        self.message()
        self.call("WebDriver:NewSession", capabilities={})

    def message(self):
        while b":" not in self.buffer:
            self.buffer += self.more()
        length, self.buffer = self.buffer.split(b":", 1)
        while len(self.buffer) < int(length):
            self.buffer += self.more()
        text, self.buffer = self.buffer[: int(length)], self.buffer[int(length) :]
        return json.loads(text)

    def more(self):
        piece = self.stream.recv(1 << 20)
        check(piece, "Firefox has ended")
        return piece

    def call(self, name, **arguments):
        self.number += 1
        text = json.dumps([0, self.number, name, arguments]).encode()
        self.stream.sendall(str(len(text)).encode() + b":" + text)
        _, _, error, result = self.message()
        check(error is None, f"{name}: {error}")
        return result

    def open(self, page):
        self.call("WebDriver:Navigate", url=page.as_uri())

    def ask(self, expression):
        return self.call("WebDriver:ExecuteScript", script=f"return ({expression})", args=[], sandbox=None)["value"]

    def close(self):
        self.process.kill()
        self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)


class WebKit:
    def __init__(self):
        browser = glob.glob("/usr/lib/*/webkit2gtk-4.*/MiniBrowser")
        self.port = free_port()
        self.process = subprocess.Popen(["WebKitWebDriver", f"--port={self.port}"], **QUIET)
        options = {"webkitgtk:browserOptions": {"binary": browser[0], "args": ["--automation"]}}
        self.session = (
            "/session/"
            + patiently(lambda: self.call("POST", "/session", {"capabilities": {"alwaysMatch": options}}), "WebKit")["sessionId"]
        )

    def call(self, method, path, body=None):
        request = urllib.request.Request(
            f"http://127.0.0.1:{self.port}{path}",
            method=method,
            data=None if body is None else json.dumps(body).encode(),
            headers={"Content-Type": "application/json"},
        )
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
            return json.load(answer)["value"]

    def open(self, page):
        self.call("POST", self.session + "/url", {"url": page.as_uri()})

    def ask(self, expression):
        return self.call("POST", self.session + "/execute/sync", {"script": f"return ({expression})", "args": []})

    def close(self):
        try:
            self.call("DELETE", self.session)
        finally:
            self.process.kill()
            self.process.wait()


def run(browser, page, wanted):
    browser.open(page)
    wait_until(browser, "!!window.sandglassPage || document.getElementById('says').textContent !== ''")
    check(browser.ask("document.getElementById('says').textContent") == "", browser.ask("document.getElementById('says').textContent"))
    browser.ask(
        "(window.wrong = [], addEventListener('error', (e) => wrong.push(e.message)), addEventListener('unhandledrejection', (e) => wrong.push(String(e.reason))), true)"
    )
    wait_until(browser, "!sandglassPage.page.turning.turns")
    browser.ask("(sandglassPage.page.turnOver(), true)")
    check(browser.ask("sandglassPage.page.turning.turns"), "the hourglass does not turn")
    browser.ask("(document.querySelector('[value=pour]').click(), true)")
    wait_until(browser, "sandglassPage.page.scene.report.sand.particles > 300")
    # Of the picture, where the heap's foot is: sand is drawn there, and it is warmer than the studio.
    drawn = browser.ask("""((page) => { const { gl, canvas } = page.painter, p = new Uint8Array(4), counts = [];
        page.draw();
        for (let y = 0.1; y < 0.9; y += 0.02) for (let x = 0.1; x < 0.9; x += 0.02) {
          gl.readPixels(x * canvas.width, y * canvas.height, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, p);
          counts.push(p[0] > 1.35 * p[2]);
        }
        return [counts.filter((warm) => warm).length, gl.getError()]; })(sandglassPage.page)""")
    check(drawn[0] > 10 and drawn[1] == 0, f"sand is seen at {drawn[0]} places, error {drawn[1]}")
    browser.ask(f"(sandglassPage.page.measuring = true, void sandglassPage.fixedRun({FRAMES}).then(r => {{ window.ran = r; }}), true)")
    wait_until(browser, "!!window.ran")
    ran = browser.ask("window.ran")
    print(browser.ask("navigator.userAgent"), ran)
    check(ran["hash"] == wanted, f"the page ends in {ran['hash']} and the program in {wanted}")
    check(browser.ask("window.wrong") == [], f"errors: {browser.ask('window.wrong')}")


def main():
    web_scene, sandglass, npm, work, which = sys.argv[1:]
    program = {"firefox": "firefox-esr", "webkit": "WebKitWebDriver"}[which]
    if not shutil.which(program) or not os.environ.get("DISPLAY"):
        print(f"no {program}" if not shutil.which(program) else "no screen: run it under xvfb-run")
        return SKIPPED
    work = pathlib.Path(work).resolve()
    work.mkdir(parents=True, exist_ok=True)
    page = assemble(web_scene, npm, work)
    browser = Firefox() if which == "firefox" else WebKit()
    try:
        run(browser, page, native_hash(sandglass, FRAMES))
    finally:
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
