#!/usr/bin/env python3
"""Sand in three.js and Babylon.js, by WebGL and WebGPU: one frame of three scenes is the kit's own picture in each, a fault is not; and in three.js
sand is changed, hidden, hit and freed as any mesh is, and seen behind glass.

renderers_test.py NPM_FOLDER WORK_FOLDER [--all]    WORK_FOLDER has node_modules. --all: what is slower, and the oldest three.js that are
supported, from the npm registry; the one before is refused.
Exit code 77: there is no Chromium here."""

import base64
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "page"))
from browser import CHROMIUM, SKIPPED, SOFTWARE, Browser, served
from engines_test import stool

HERE = pathlib.Path(__file__).parent / "renderers"
GPU = (*SOFTWARE, "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader")
SCENES = ("pour onto a chair", "a model in a photograph", "hourglass")
FAULTS = ("no sun share", "interpolated origin", "linear for sRGB")
# A picture may be off by so much in the mean, of 255; and so many of the sand's pixels by more than 4.
MEAN, SHARE = 1.0, 0.001
THREE = "/node_modules/three/build/three."
MAP = {
    "three": f"{THREE}module.js",
    "three/webgpu": f"{THREE}webgpu.js",
    "three/addons/": "/node_modules/three/examples/jsm/",
    "babylon": "/renderers/babylon_core.js",
    **{f"sandglass/{name}": f"/renderers/sandglass/{name}.mjs" for name in ("stage", "three", "babylon", "glsl")},
}
PAGE = """<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><script type="importmap">{map}</script>
<script type="module">
const wanted = new URLSearchParams(location.search).get("without");
const own = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {{
  if (kind === wanted) throw new Error(`this page gives no context of ${{kind}}`);
  return own.call(this, kind, ...more);
}};
globalThis.renderers = {{ ...(await import("/renderers/renderers.mjs")), ...(await import("/renderers/views.mjs")), ...(await import("/renderers/rounds.mjs")), ...(await import("/renderers/by_depth.mjs")) }};
globalThis.ready = true;
</script>"""


def check(right, sentence):
    print(("" if right else "WRONG: ") + sentence, flush=True)
    check.wrong += not right


check.wrong = 0


class Page:
    """One browser for a page; its complaints are faults, but for the driver's about reading pixels."""

    def __init__(self, address):
        self.browser = Browser(CHROMIUM, width=400, height=400, flags=GPU)
        self.browser.open(address)
        end = time.monotonic() + 60
        while not self.browser.ask("!!globalThis.ready") and time.monotonic() < end:
            time.sleep(0.05)

    def ask(self, call):
        return self.browser.ask(f"renderers.{call}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        told = [
            text
            for text in self.browser.complaints
            if "ReadPixels" not in text
            and "loseContext" not in text
            and "context lost" not in text.lower()
            and "context successfully" not in text
        ]
        check(not told, f"the page complains of nothing: {told[:3]}")
        self.browser.close()


def prepare(npm, work):
    """All lies in a folder of its own, as other tests install the package."""
    folder = work / "renderers"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(HERE, folder)
    shutil.copytree(npm, folder / "sandglass")
    shutil.copy(HERE.parents[2] / "models/page/hourglass.mjs", folder / "sandglass")
    shutil.copy(npm.parent / "page/hourglass.bin", folder)
    shutil.copy(HERE.parents[2] / "models/pictures/room.jpg", folder)
    (folder / "index.html").write_text(PAGE.format(map=json.dumps({"imports": MAP})))
    (folder / "babylon_core.mjs").write_text('export * from "@babylonjs/core";\n')
    bundle = ["--bundle", "--format=esm", "--outfile=renderers/babylon_core.js", "--log-level=error"]
    subprocess.run(["node_modules/.bin/esbuild", "renderers/babylon_core.mjs", *bundle], cwd=work, check=True, timeout=300)
    return served(work) + "renderers/index.html", folder


def within(found):
    return found["mean"] <= MEAN and found["over"] <= SHARE


def words(found):
    return f"mean {found['mean']:.3f} of 255, {found['over']:.3%} of {found['sand']} pixels by more than 4"


def same_picture(page, folder, engine, kind, faults=FAULTS, scenes=SCENES):
    """Of each scene; a left-handed scene, and faults, of the first."""
    for name, left in [(name, False) for name in scenes] + [(SCENES[0], True)] * (engine == "babylon"):
        found = page.ask(f"same({json.dumps(engine)}, {json.dumps(kind)}, {json.dumps(name)}, {json.dumps(left)})")
        way = f"{engine}, {kind}{', left-handed' if left else ''}"
        (folder / "pictures").mkdir(exist_ok=True)
        (folder / "pictures" / f"{name}, {way}.png").write_bytes(base64.b64decode(found["picture"].split(",")[1]))
        kit = found["kit"]
        check(within(found), f"{name}: {way}: {words(found)}; {found['ms']:.0f} ms, the kit {kit['ms']:.0f}")
        # One more: WebGPURenderer encodes its picture by a square.
        check(found["calls"] <= kit["calls"] + (engine == "three"), f"{way}: {found['calls']} draw calls, the kit {kit['calls']}")
    for fault in faults if engine == "three" else ():
        found = page.ask(f"fault({json.dumps(kind)}, {json.dumps(fault)})")
        check(not within(found), f"{engine}, {kind}, {fault}: {words(found)}, as it must")


def as_a_mesh(page, kind):
    ways = page.ask(f"besideABall({json.dumps(kind)})")
    plain = ways.pop("plain")
    for name, seen in ways.items():
        # Each channel goes up or down as the ball's does, and about as far.
        sand, ball = ([seen[of][k] / plain[of][k] for k in range(3)] for of in ("sand", "ball"))
        alike = all(abs(a - b) < 0.06 for a, b in zip(sand, ball))
        changed = max(abs(b - 1) for b in ball) > 0.1
        check(alike and changed, f"{kind}, {name}: sand {[round(x, 2) for x in sand]}, a ball {[round(x, 2) for x in ball]} of before")

    def counted(*names, **options):
        return page.ask(f"counted({json.dumps(kind)}, {json.dumps(names)}, {json.dumps(options)})")

    shares = {"an occluder beneath": 1, "a stencil test before": 1, "two viewports": 1, "its group moved out": 0, "a wall before it": 0}
    alone, *counts = counted("alone", *shares)
    for (name, share), seen in zip(shares.items(), counts):
        check(abs(seen - share * alone) <= 0.02 * alone, f"{kind}, {name}: {seen} pixels of sand, {alone} alone")
    one, two, both = page.ask(f"twoStages({json.dumps(kind)})")
    check(min(one, two) > 500 and both == one + two, f"{kind}: {one} pixels are sand of one stage, {two} of another, {both} of both")
    share = page.ask(f"casts({json.dumps(kind)})")
    check(share > 0.05, f"{kind}: on a floor a shadow of three's own light changes {share:.0%}")
    # The last: once one renderer has reversed depth, three draws nothing by others of the page.
    for depth in ("logarithmicDepthBuffer", "reversedDepthBuffer"):
        seen, hidden = counted("alone", "a wall before it", **{depth: True})
        check(abs(seen - alone) < 0.02 * alone and hidden == 0, f"{kind}, {depth}: {seen} pixels of sand, {hidden} behind a wall")
    found = page.ask(f"hit({json.dumps(kind)})")
    check(found["beside"] < found["radius"], f"{kind}: a ray ends {found['beside']:.4f} m from sand whose radius is {found['radius']:.4f}")
    check(found["outside"] == 0, f"{kind}: {found['outside']} of the sand's vertices are outside of its box")


def rounds(page, engine, kind):
    found = page.ask(f"left({json.dumps(engine)}, {json.dumps(kind)})")
    counts, within = found["counts"], found["within"]
    check(counts[-1] == counts[1] != within, f"{engine}, {kind}: after 2 of 10 stages it holds {counts[1]}, at last {counts[-1]}")


def babylon_depth(page, kind):
    for way in ("plain", "reversed", "logarithmic"):
        hidden, seen, alone = page.ask(f"babylonDepth({json.dumps(kind)}, {json.dumps(way)})")
        right = alone > 1000 and hidden == 0 and abs(seen - alone) < 0.02 * alone
        check(right, f"babylon, {kind}, {way} depth: {alone} pixels of sand, {seen} before a wall, {hidden} behind one")


def floors(page, kind):
    clipped, alone = page.ask(f"counted({json.dumps(kind)}, ['half clipped', 'alone'])")
    check(0.1 * alone < clipped < 0.9 * alone, f"{kind}, half clipped: {clipped} of {alone} pixels of sand")
    found = page.ask(f"floors({json.dumps(kind)})")
    check(found["floor"] > 1000 and max(found["twice"], found["instanced"], found["batched"]) < 0.01, f"{kind}, floors: {found}")


def views(page, kind):
    """Several attachments, and the two eyes of a headset."""
    attached = page.ask(f"attachments({json.dumps(kind)})")
    check(attached["sand"] > 1000 and attached["over"] == 0, f"three, {kind}, two attachments: {words(attached)}")
    check(kind == "webgl" or attached["second"] > 1000, f"three, {kind}: {attached['second']} pixels of the second are normals")
    # No browser has sessions of WebGPU.
    ways = {"three, two eyes": page.ask(f"eyes({json.dumps(kind)}, {json.dumps(kind != 'nodes')})")}
    if kind != "nodes on webgl":
        ways["babylon, two eyes"] = page.ask(f"babylonEyes({json.dumps(kind)})")
        found = page.ask(f"prepass({json.dumps(kind)})")
        check(within(found), f"babylon, {kind}, a prepass of two attachments: {words(found)}")
    for way, found in ways.items():
        check(within(found) and found["other"] > 0.1, f"{way}, {kind}: {words(found)}; exchanged, {found['other']:.0%}")


def glass(page, kind):
    found = page.ask(f"behindGlass({json.dumps(kind)})")
    seen, heap, blended = (found[of] for of in ("sand", "heap", "blended"))

    def alike(shares):
        return all(abs(a - b) < 0.06 for a, b in zip(shares, heap))

    told = f"{[round(x, 2) for x in seen]} of before, a standard heap {[round(x, 2) for x in heap]}"
    check(found["count"] > 500 and alike(seen), f"three, {kind}: sand behind glass is {told}")
    check(found["other"] < 0.02, f"three, {kind}: {found['other']:.1%} of {found['count']} pixels are behind glass for one of both")
    check(not alike(blended), f"three, {kind}: transparent sand is {[round(x, 2) for x in blended]} of before, as it must")


def babylon_mesh(page, kind):
    found = page.ask(f"babylonMesh({json.dumps(kind)}, {json.dumps(kind == 'nodes')})")
    check(found["beside"] < found["radius"], f"babylon, {kind}: a ray ends {found['beside']:.4f} m from sand")
    for name, share in found["changed"].items():
        check(0.02 < share, f"babylon, {kind}, {name}: {share:.1%} of the picture is another")


def restored(page):
    for engine, lost in (("three", page.ask("lost()")), ("babylon", page.ask("babylonLost()"))):
        same = lost["sand"] > 1000 and lost["over"] < SHARE and lost["error"] == 0
        check(same, f"{engine}, a lost context: {lost['over']:.3%} of {lost['sand']} pixels are others after it")
    check(lost["shadow"] > 0.1, f"there shadows change {lost['shadow']:.0%} of the picture")


def raised(page, kind):
    found = page.ask(f"raised({json.dumps(kind)})")
    check(found["off"] <= 2 and found["control"] > 40, f"three, {kind}: what stands on the floor, off by: {found}")
    check(found["place"] <= 1 and found["placeControl"] > 40, f"three, {kind}: a place, off by: {found}")


BOOKS = (0, 0.05, 0.15)  # metres


def by_formula(name, found):
    """In 1/255 of the formula, but for pixels on a rim; without a depth, or by one that is off, it is another picture."""
    most = {"image": 0, "a turned image": 0, "heights": 0.001, "a depth buffer": 0.001, "a depth renderer": 0.001, "another camera": 0.1}
    for way, (step, eight) in found.items():
        right = step <= most[way] if way in most else step > 0.3
        check(
            right, f"{name}, by depth, {way}: {step:.2%} of pixels off by 1 of 255, {eight:.2%} by 8{'' if way in most else ', as it must'}"
        )


def babylon_by_depth(page, kind):
    for left in ("false", "true"):
        found = page.ask(f"babylonByDepth({json.dumps(kind)}, {left}, {json.dumps(BOOKS)})")
        by_formula(f"babylon, {kind}{', left-handed' if left == 'true' else ''}", found)


def by_depth(page, kind):
    found = page.ask(f"byDepth({json.dumps(kind)}, {json.dumps(BOOKS)})")
    by_formula(f"three, {kind}", found)
    # It sees past some rims.
    right, wrong = (found[way][1] for way in ("another camera", "another camera taken for the view's"))
    check(
        right < 0.025 < 0.1 < wrong, f"three, {kind}: by another camera's depth {right:.2%} are off by 8, taken for the view's {wrong:.2%}"
    )
    found = page.ask(f"besideDepth({json.dumps(kind)})")
    right = max(found["darkened"]) < 0.001 * found["without"] and found["without"] > 1000
    check(
        right,
        f"three, {kind}: of a thing before it {found['darkened']} pixels are darkened, of what is there without it {found['without']}",
    )
    check(found["alpha"] <= 1, f"three, {kind}: behind the canvas off by {found['alpha']:.2f} of 255")
    found = page.ask(f"slides({json.dumps(kind)}, {json.dumps(BOOKS)}, 40)")
    slid = [1000 * book * math.tan(math.radians(40)) for book in BOOKS]
    right = all(abs(a - b) < 1 for a, b in zip(found["found"], slid)) and found["made"] == [1, 0]
    check(right, f"three, {kind}: a shadow slides {found['found']} mm, h tan {slid}; casts before and after: {found['made']}")
    check(max(map(abs, found["floor"])) < 1, f"three, {kind}: the floor's slides {found['floor']} mm, as it must")


def readme(page, folder):
    """Its example runs as it is printed, with another renderer's name: shadow and sand are seen."""
    text = "".join(re.findall(r"```js\n(.*?)```", (HERE.parents[2] / "toolchains/web/README.md").read_text(), re.DOTALL)[:2])
    for old, new in (('"three"', '"three/webgpu"'), ("WebGLRenderer", "WebGPURenderer")):
        check(text.count(old) == 1, f"the README's example says {old} once")
        text = text.replace(old, new)
    (folder / "readme.mjs").write_text(text + "globalThis.example = { renderer, scene, camera, stage, floor };\n")
    (folder / "model.glb").write_bytes(stool())
    found = page.ask("readme()")
    check(found["shadow"] > 500 and found["particles"] > 100 and found["sand"] > 300, f"the README's example by WebGPU: {found}")


def from_one_source(folder, address, before):
    """Another number in the kit's GLSL is one in the WGSL and in the nodes: all pictures change alike."""
    kit, copy, package = HERE.parents[2] / "models/kit", folder / "kit", folder / "sandglass"
    shutil.copytree(kit, copy)
    old, new = "0.77 * grain", "0.5 * grain"
    for file in (copy / "sand.glsl", package / "kit.mjs"):
        text = file.read_text()
        check(text.count(old) == 1, f"{file.name} says {old} once")
        file.write_text(text.replace(old, new))
    subprocess.run([sys.executable, "-B", kit / "languages.py", copy, package], check=True)
    with Page(address) as page:
        same_picture(page, folder, "three", "nodes", (), SCENES[:1])
        same_picture(page, folder, "babylon", "nodes", (), SCENES[:1])
        after = page.ask("light()")
        check(after < 0.99 * before, f"with {new} the kit's picture has {after / before:.3f} of the light")


VERSIONS = {"0.160.0": ["webgl"], "0.170.0": ["webgl"], "0.184.0": ["webgl", "nodes on webgl", "nodes"]}
REFUSED = {"0.159.0": "webgl", "0.183.0": "nodes on webgl"}


def versions(npm, work):
    for version, kinds in {**VERSIONS, **REFUSED}.items():
        name = f"three-{version}"
        if not (work / "node_modules" / name).exists():
            order = ["npm", "install", "--no-save", "--no-audit", "--no-fund", "--ignore-scripts", f"{name}@npm:three@{version}"]
            subprocess.run(order, cwd=work, check=True, timeout=300, stdout=subprocess.DEVNULL)
        MAP["three"], MAP["three/webgpu"] = (f"/node_modules/{name}/build/three.{build}.js" for build in ("module", "webgpu"))
        address, _ = prepare(npm, work)
        with Page(address) as page:
            if version in REFUSED:
                told = page.browser.ask(f"renderers.same('three', '{kinds}', '{SCENES[0]}').catch((error) => error.message)")
                check("or newer for this renderer" in str(told), f"three {version}: {told}")
                continue
            for kind in kinds:
                found = page.ask(f"same('three', '{kind}', '{SCENES[0]}')")
                check(within(found), f"three {version}, {kind}: {words(found)}")
                by_depth(page, kind)


def main(arguments):
    if CHROMIUM is None:
        return SKIPPED
    npm, work = map(pathlib.Path, arguments[:2])
    address, folder = prepare(npm, work)
    if arguments[2:] == ["--all"]:
        with Page(address) as page:
            babylon_mesh(page, "webgl")
            for engine, kind in (("three", "webgl"), ("three", "nodes on webgl"), ("babylon", "webgl")):
                rounds(page, engine, kind)
        with Page(address + "?without=webgl2") as page:
            views(page, "nodes")
            babylon_mesh(page, "nodes")
            for engine in ("three", "babylon"):
                rounds(page, engine, "nodes")
            readme(page, folder)
        versions(npm, work)
        return 1 if check.wrong else 0
    with Page(address) as page:
        same_picture(page, folder, "three", "webgl")
        same_picture(page, folder, "three", "nodes on webgl", ())
        same_picture(page, folder, "babylon", "webgl")
        as_a_mesh(page, "webgl")
        restored(page)
        babylon_depth(page, "webgl")
        babylon_by_depth(page, "webgl")
        for kind in ("webgl", "nodes on webgl"):
            floors(page, kind)
            raised(page, kind)
            by_depth(page, kind)
            views(page, kind)
            glass(page, kind)
    # What draws by WebGPU must do without WebGL.
    address += "?without=webgl2"
    with Page(address) as page:
        same_picture(page, folder, "three", "nodes")
        raised(page, "nodes")
        by_depth(page, "nodes")
        same_picture(page, folder, "babylon", "nodes")
        babylon_depth(page, "nodes")
        babylon_by_depth(page, "nodes")
        floors(page, "nodes")
        glass(page, "nodes")
        as_a_mesh(page, "nodes")
        before = page.ask("light()")
    from_one_source(folder, address, before)
    return 1 if check.wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
