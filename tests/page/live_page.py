"""What tests of the live page do with it: they put it together, wait for what comes at any speed, drop files and count frames."""

import base64
import json
import math
import pathlib
import struct
import subprocess
import sys
import time

from browser import check

ROOT = pathlib.Path(__file__).resolve().parents[2]
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0.5 0 0.9\nv 0.5 0.9 0.3\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n"
CUBE = (
    "".join(f"v {k & 1} {k >> 1 & 1} {k >> 2}\n" for k in range(8)) + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
)


def ball(rings=12, around=24):
    points = [(0, -1, 0), (0, 1, 0)] + [
        (
            math.sin(math.pi * r / rings) * math.cos(2 * math.pi * k / around),
            -math.cos(math.pi * r / rings),
            math.sin(math.pi * r / rings) * math.sin(2 * math.pi * k / around),
        )
        for r in range(1, rings)
        for k in range(around)
    ]

    def at(r, k):
        return 0 if r == 0 else 1 if r == rings else 2 + (r - 1) * around + k % around

    faces = [
        f
        for r in range(rings)
        for k in range(around)
        for f in ((at(r, k), at(r + 1, k), at(r + 1, k + 1)), (at(r, k), at(r + 1, k + 1), at(r, k + 1)))
        if len(set(f)) == 3
    ]
    return "".join("v %.6f %.6f %.6f\n" % p for p in points) + "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)


BALL = ball()


def wait_until(browser, expression, patience=240):
    end = time.monotonic() + patience
    while not browser.ask(expression):
        check(time.monotonic() < end, f"never true: {expression}")
        time.sleep(0.3)


def native_hash(sandglass, frames):
    out = subprocess.run(
        [sandglass, "run", str(ROOT / "models/page/page.json"), "--frames", str(frames), "--clock", "virtual", "--budget-ms", "100000"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    return next(line.split()[1] for line in out.splitlines() if line.startswith("hash "))


def assemble(web_scene, npm, work):
    scene, page = work / "page.json", work / "sandglass.html"
    subprocess.run([web_scene, ROOT / "models/page/page.json", scene, "--counted"], check=True)
    subprocess.run([sys.executable, ROOT / "models/page/assemble.py", npm, pathlib.Path(npm).parent / "page", scene, page], check=True)
    return page


def gltf_tetrahedron():
    places = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0.5, 0, 0.9, 0.5, 0.9, 0.3)
    corners = struct.pack("<12H", 0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0)
    uri = "data:application/octet-stream;base64," + base64.b64encode(places + corners).decode()
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
            ],
            "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
            "buffers": [{"byteLength": 72, "uri": uri}],
        }
    )


def drop(browser, name, text):
    browser.ask(f"""(() => {{ const data = new DataTransfer(); data.items.add(new File([{text!r}], {name!r}));
        document.getElementById('says').textContent = '';
        dispatchEvent(new DragEvent('drop', {{dataTransfer: data, bubbles: true, cancelable: true}})); }})()""")
    wait_until(browser, "document.getElementById('says').textContent !== ''")
    return browser.ask("document.getElementById('says').textContent")


def run_frames(browser, count, acts="", until="false"):
    """So many frames at most, by no clock: the page's own loop must stand still (`measuring`)."""
    browser.ask(f"""(() => {{ const {{page}} = sandglassPage, last = page.scene.frames + {count};
        {acts};
        while (page.scene.frames < last && !({until})) page.advance(1 / 60);
        page.draw(); }})()""")


def set_budget(browser, ms):
    browser.ask(f"document.getElementById('budget').value = {ms}; document.getElementById('budget').dispatchEvent(new Event('input'))")


def particles_of(said):
    return int(said.split()[0].replace(",", ""))


def report(browser, field):
    return browser.ask(f"sandglassPage.page.scene.report.{field}")


# Where the particles are: [x, y, z] of each.
PLACES = """(() => { const {page} = sandglassPage, n = page.scene.report.sand.particle_numbers, p = page.sand.allocate(12 * n);
    page.sand.sandglass_scene_particles(page.scene.handle, p, 0);
    const x = page.sand.floats(p, 3 * n);
    const places = Array.from({ length: n }, (_, i) => [...x.subarray(3 * i, 3 * i + 3)]);
    page.sand.free(p);
    return places; })()"""


def place_on_view(browser, right, down):
    return browser.ask(
        f"(({{ left, top, width, height }}) => [left + {right} * width, top + {down} * height])(document.getElementById('view').getBoundingClientRect())"
    )
