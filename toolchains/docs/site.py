#!/usr/bin/env python3
"""The site, as static files: site.py SOURCE PAGE REFERENCE FOLDER

It opens with the live page PAGE; below, one sample a capability by name, each a page of its own, and the API reference, a copy of the
folder REFERENCE. FOLDER is made anew."""

import html
import pathlib
import re
import shutil
import sys

# Capability, its sample, its header. Of a .md file the first block of that language is shown.
SAMPLES = [
    ("Sand, drawn as a surface", "models/examples/pour.cpp", "skin.h"),
    ("Sand from C", "models/examples/hello.c", "scene.h"),
    ("Bodies that sand carries", "models/examples/bodies.cpp", "bodies.h"),
    ("The light of the room", "models/examples/camera_app.cpp", "room.h"),
    ("The soft shadow of an object", "models/examples/shadow_alone.cpp", "shadow.h"),
    ("In three.js: a model with a shadow, and sand", "toolchains/web/README.md", "cast.h"),
    ("Sand in GLSL", "models/kit/surface.frag", "skin.h"),
]
STYLE = """body{margin:0;font:16px/1.5 system-ui,sans-serif;color:#222;background:#f4f1ea}main{max-width:52rem;margin:auto;padding:1rem}
iframe{display:block;width:100%;height:min(78vh,720px);border:0}pre{overflow:auto;padding:1rem;background:#fff;font-size:13px}a{color:#7a4a12}"""


def page(title, body):
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{html.escape(title)}</title>'
        f"<style>{STYLE}</style>{body}</html>\n"
    )


def code_of(path):
    text = path.read_text()
    if path.suffix != ".md":
        return text
    block = re.search(r"```js\n(.*?)```", text, re.DOTALL)
    if block is None:
        sys.exit(f"site.py: {path} has no block of JavaScript")
    return block.group(1)


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    source, live, reference, folder = map(pathlib.Path, sys.argv[1:])
    for needed in (live, reference / "index.html"):
        if not needed.exists():
            sys.exit(f"site.py: there is no {needed}: run ./sg page and ./sg docs")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copyfile(live, folder / "live.html")
    shutil.copytree(reference, folder / "reference")
    links = ""
    for title, sample, header in SAMPLES:
        code = code_of(source / sample)
        name = re.sub(r"\W+", "-", title.lower()) + ".html"
        at = "reference/" + header.replace(".", "_8") + ".html"
        if not (folder / at).exists():
            sys.exit(f"site.py: the reference has no page {at}")
        links += f'<li><a href="{name}">{html.escape(title)}</a></li>'
        (folder / name).write_text(
            page(
                title,
                f'<main><p><a href="index.html">Sandglass</a></p><h1>{html.escape(title)}</h1>'
                f'<p><code>{sample}</code>; the API: <a href="{at}">{header}</a></p><pre>{html.escape(code)}</pre></main>',
            )
        )
    (folder / "index.html").write_text(
        page(
            "Sandglass",
            '<iframe src="live.html" title="Sand and light, live" allow="camera; accelerometer; gyroscope; xr-spatial-tracking"></iframe>'
            "<main><h1>Sandglass</h1><p>Sand, light and shadow for augmented reality, inside a fixed slice of every frame. Above it runs in this browser.</p>"
            f'<h2>Samples</h2><ul>{links}</ul><p><a href="reference/index.html">API reference</a></p></main>',
        )
    )


main()
