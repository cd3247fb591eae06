#!/usr/bin/env python3
"""The README's two examples in headless Chromium, by an import map, Vite (served and built) and esbuild, and with Babylon.js in
scenes of both hands: shadow and sand are seen, the light is the library's, memory may grow, and the page's thread stays free.

engines_test.py NPM_FOLDER WORK_FOLDER README    WORK_FOLDER has node_modules, and gets pictures/*.png.
Exit code 77: there is no Chromium here."""

import http.server
import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "page"))
from browser import CHROMIUM, SKIPPED, SOFTWARE, Browser, Files, served

PATIENCE = 60
PLACES = (0.5, 0.88), (0.1, 0.9)  # of the README's picture: a shadow, and the floor beside it
HERE = pathlib.Path(__file__).parent / "engines"
MAP = {"three": "three/build/three.module.js", "three/addons/": "three/examples/jsm/", "sandglass/three": "sandglass/three.mjs"}
HANDLES = """
import "./three_cube.mjs";
await stage.stage.fields;
const step = () => { stage.update(1 / 60), renderer.render(scene, camera); };
Object.assign(globalThis, { THREE, createStage, renderer, scene, camera, stage, model, floor, step, room, photo: room.image, gl: renderer.getContext() });
"""
# Runs frames, and gives the mean of the picture's red, green and blue about shares of its width and height, linear; or those of the
# photograph, with `frames` below 0.
LOOK = """((frames, places) => {
  const side = 8, pixels = new Uint8Array(4 * side * side), { drawingBufferWidth: width, drawingBufferHeight: height } = gl, flat = new OffscreenCanvas(width, height).getContext("2d");
  const read = (x, y) => (gl.readPixels(x, height - y - side, side, side, gl.RGBA, gl.UNSIGNED_BYTE, pixels), pixels), see = (x, y) => flat.getImageData(x, y, side, side).data;
  const mean = (of) => [0, 1, 2].map((k) => of.reduce((sum, byte, i) => sum + (i % 4 === k ? (byte / 255) ** 2.2 : 0), 0) / (side * side));
  for (let i = 0; i < frames; ++i) stage.update(1 / 60);
  if (frames < 0) flat.drawImage(photo, 0, 0, width, height); else step();
  return places.map(([x, y]) => mean((frames < 0 ? see : read)(Math.round(x * width), Math.round(y * height))));
})"""
REFUSED = {
    "createStage(THREE, { renderer, scene, source: 'index.html' })": 'optimizeDeps: { exclude: ["sandglass"] }',
    "createStage(THREE, { renderer: {}, scene })": "needs the renderer of three",
    "stage.receive(new THREE.MeshBasicMaterial())": "no shadow falls on a MeshBasicMaterial",
    "stage.receive(model)": "receive takes the material of a mesh",
    "stage.see(photo, new THREE.OrthographicCamera())": "needs a camera with perspective",
    "stage.addModel({ scene: model })": "Of a loaded glTF pass gltf.scene",
    "stage.pour({ position: [0, 1, 0] })": "Call createSand first",
    "stage.update(NaN)": "the seconds since the last frame",
    "createStage(THREE, { renderer, scene, bugdet: 3 })": "It takes: sand, source, threads, origin, half, height, budget",
    "createStage(THREE, { renderer, scene, origin: 3 })": "origin must be 3 numbers",
    "stage.receive(floor.material, { shadowonly: true })": "It takes: shadowOnly",
    "stage.receiveByDepth({ depth: scene })": "Of a render target pass its depthTexture",
    "stage.receiveByDepth({ depth: room })": "Pass { metres }",
    "stage.receiveByDepth({ heights: { cells: [16, 16], heights: [0] } })": "a height for each of 16 x 16 cells, not 1",
    "stage.see(room, camera)": "Of a texture pass its image",
    "stage.createSand({ particles: 'many' })": "particles must be a number above 0",
    "stage.createSand().then(() => stage.pour({ position: [0, NaN, 0] }))": "position must be 3 numbers",
}
# Of a mirrored box of 1 x 2 x 3 m, by its triangles' windings.
VOLUME = """(() => {
  const box = new THREE.Mesh(new THREE.BoxGeometry(1, 2, 3)), corner = (i) => new THREE.Vector3().fromArray(mesh.positions, 3 * mesh.indices[i]);
  box.scale.x = -1;
  const mesh = stage.meshOf(box, stage.poseOf(box));
  return [...mesh.indices.keys()].filter((i) => i % 3 === 0).reduce((sum, i) => sum + corner(i).dot(corner(i + 1).cross(corner(i + 2))) / 6, 0);
})()"""
WORKER = """(async () => {
  renderer.setAnimationLoop(null);
  const far = await createStage(THREE, { renderer, scene: new THREE.Scene(), worker: true }), pause = () => new Promise((done) => setTimeout(done, 4));
  const knot = () => new THREE.Mesh(new THREE.TorusKnotGeometry(0.06, 0.02, 400, 60)), take = far.take.bind(far), adding = [], frames = [];
  let longest = 0, before = performance.now(), done = false, own = 0;
  for (let i = 0; i < 3; ++i) {  // what else this machine does may fall into one of them
    const one = knot(), begin = performance.now(), added = far.addModel(one, { collide: i === 0 });
    adding.push(performance.now() - begin), await added;
  }
  await far.createSand({ particles: 2000 });
  const begin = performance.now();
  far.stage.fields.then(() => { done = true; });
  for (before = performance.now(); !done; before = performance.now()) await pause(), longest = Math.max(longest, performance.now() - before);
  const field = performance.now() - begin;
  far.pour({ position: [0, 0.5, 0] });
  far.take = (drawn) => { const from = performance.now(); take(drawn), own += performance.now() - from; };
  for (let i = 0; i < 240; ++i) { const from = performance.now(); far.update(1 / 60), own += performance.now() - from; await pause(); frames.push(own), own = 0; }
  return { field, longest, adding: Math.min(...adding), vertices: knot().geometry.getAttribute("position").count, frame: frames.sort((a, b) => a - b)[120], particles: far.drawn.particles };
})()"""

# A table in a turned and stretched group, its top 0.2 m high, between the camera and a red post. Colours of what is behind its top, as it
# is, as a place, in the shadow of a ball above it, withdrawn, and withdrawn and hidden; how low sand lies on it, and without it.
PLACE = """(async () => {
  renderer.setAnimationLoop(null);
  const own = new THREE.Scene(), eye = new THREE.PerspectiveCamera(40, 1, 0.1, 10), pause = () => new Promise((done) => setTimeout(done, 4));
  const mesh = (geometry, color) => new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color }));
  const table = mesh(new THREE.BoxGeometry(0.4, 0.1, 0.2), 0x00ff00), group = new THREE.Group().add(table), post = mesh(new THREE.BoxGeometry(0.1, 1, 0.1), 0xff0000);
  group.scale.set(1, 2, 2), group.rotation.y = Math.PI / 2, group.position.y = 0.1, post.position.set(0, 0, -0.4);
  own.background = new THREE.Color(1, 1, 1), own.add(post, group);  // what is drawn first is behind
  eye.position.set(0, 0.6, 0.8), eye.lookAt(0, 0.2, 0);
  const far = await createStage(THREE, { renderer, scene: own, worker: true }), take = far.take.bind(far);
  let low = 9;
  far.take = (drawn) => { take(drawn); if (drawn.skin) low = drawn.skin.low[1]; };
  await far.see(photo, camera);
  const frames = async (count) => { for (let i = 0; i < count; ++i) { far.update(1 / 60); while (far.busy) await pause(); } };
  const seen = async (x, y, z, count = 2) => {
    await frames(count), renderer.render(own, eye);
    const at = new THREE.Vector3(x, y, z).project(eye), pixel = new Uint8Array(4);
    gl.readPixels((at.x + 1) / 2 * gl.drawingBufferWidth, (at.y + 1) / 2 * gl.drawingBufferHeight, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return [...pixel].slice(0, 3);
  };
  const behind = () => seen(0, 0.2, -0.15), found = { plain: await behind() };
  const place = await far.addPlace(group);
  found.place = await behind(), found.beside = await seen(0, 0.4, -0.35);
  const ball = mesh(new THREE.SphereGeometry(0.07), 0x0000ff);
  ball.position.set(0, 0.275, 0), own.add(ball);
  await far.addModel(ball, { collide: false });
  await frames(60), ball.removeFromParent();
  ball.visible = true, own.add(ball), ball.layers.set(3);  // casts, and is not drawn
  found.dark = await seen(0, 0.2, 0, 60), found.lit = await seen(-0.18, 0.2, 0.18), found.error = gl.getError();
  await far.removeModel(ball);
  await far.createSand({ particles: 400 }), await far.stage.fields;
  far.pour({ position: [0, 0.4, 0] }), await frames(120), found.on = low;
  far.pour(), await place.dispose(), await frames(120), found.under = low;
  found.again = await behind(), group.visible = false, found.without = await behind();
  // An emulated device above the floor: its depth has a block of 0.4 x 0.4 x 0.1 m, noisy by 1 mm; and a hand away from the sand.
  const [width, height, focal] = [80, 60, 56], orientation = { x: -Math.SQRT1_2, y: 0, z: 0, w: Math.SQRT1_2 };
  const view = { transform: { position: { x: 0, y: 0.6, z: 0, w: 1 }, orientation }, projectionMatrix: Float32Array.from({ length: 16 }, (_, i) => ({ 0: 2 * focal / width, 5: 2 * focal / height })[i] ?? 0) };
  const joints = new Map(Array.from({ length: 25 }, (_, i) => [i, i])), frame = { session: { inputSources: [{ handedness: "left", hand: joints }] }, getJointPose: () => ({ radius: 0.01, transform: { position: { x: 1, y: 1, z: 1, w: 1 } } }) };
  for (let round = 0; round < 30; ++round) {
    const data = Float32Array.from({ length: width * height }, (_, i) => (Math.max(Math.abs(i % width - 39.5), Math.abs(Math.floor(i / width) - 29.5)) * 0.5 / focal < 0.2 ? 0.5 : 0.6) + ((7 * i + round) % 3 - 1) / 1000).buffer;
    await far.seeDepth({ width, height, data, rawValueToMeters: 1, normDepthBufferFromNormView: { matrix: new THREE.Matrix4().elements } }, view), await far.seeHands(frame, {}), await frames(1);
  }
  await far.createSand({ particles: 400 }), far.pour({ position: [0, 0.4, 0] }), await frames(120), found.seen = low;
  far.dispose();
  return found;
})()"""

# With Babylon.js: a red post, then a green table before it. The picture where the table hides the post: with neither, with both, as a
# place, and withdrawn.
BABYLON_PLACE = """(async () => {
  const { BABYLON, scene, z } = stage, engine = scene.getEngine(), size = { width: 0.5, height: 0.3, depth: 0.3 };
  engine.stopRenderLoop();
  const mesh = (size, colour, ...at) => {
    const one = BABYLON.CreateBox("", size, scene), material = new BABYLON.StandardMaterial("", scene);
    one.position.set(...at), one.material = Object.assign(material, { disableLighting: true, emissiveColor: BABYLON.Color3.FromArray(colour) });
    return one;
  };
  const seen = async () => {
    await scene.whenReadyAsync();
    for (let i = 0; i < 40; ++i) step();
    const pixel = new Uint8Array(4), { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const at = BABYLON.Vector3.Project(new BABYLON.Vector3(0.75, 0.2, 0.5 * z), BABYLON.Matrix.Identity(), scene.getTransformMatrix(), new BABYLON.Viewport(0, 0, width, height));
    gl.readPixels(at.x, height - at.y, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return [...pixel].slice(0, 3);
  };
  const found = { bare: await seen() };
  const post = mesh({ width: 0.3, height: 0.4, depth: 0.1 }, [1, 0, 0], 0.91, 0.1, 0.2 * z), table = mesh(size, [0, 1, 0], 0.75, 0.15, 0.6 * z);
  table.isVisible = false, found.post = await seen();
  table.isVisible = true, found.both = await seen();
  const place = await stage.addPlace(table);
  found.place = await seen(), await place.dispose(), found.again = await seen();
  post.dispose(), table.dispose();
  return { ...found, error: gl.getError() };
})()"""


# What the renderer holds before a stage, and after ten.
ROUNDS = """(async () => {
  const own = new THREE.Scene(), ground = new THREE.Mesh(new THREE.PlaneGeometry(1, 1)), box = new THREE.Mesh(new THREE.BoxGeometry(0.1, 0.1, 0.1)), { info } = renderer;
  const held = () => (renderer.render(own, camera), [info.memory.textures, info.memory.geometries, info.programs.length, own.children.length]);
  renderer.setAnimationLoop(null), own.add(ground, box);
  const { material } = ground, before = held();
  for (let i = 0; i < 10; ++i) {
    const one = await createStage(THREE, { renderer, scene: own });
    ground.material = one.receive(new THREE.MeshStandardMaterial());
    await one.see(photo, camera), await one.addModel(box), await one.createSand({ particles: 100 });
    one.update(1 / 60), renderer.render(own, camera), one.dispose(), ground.material.dispose(), ground.material = material, held();
  }
  return [before, held()];
})()"""


def check(right, sentence):
    print(("" if right else "WRONG: ") + sentence, flush=True)
    if not right:
        sys.exit(1)


def stool():
    """A .glb of five boxes: a seat of 40 cm, 45 cm high."""
    boxes = [((-0.2, 0.42, -0.2), (0.2, 0.45, 0.2))] + [
        ((x, 0, z), (x + 0.04, 0.42, z + 0.04)) for x in (-0.19, 0.15) for z in (-0.19, 0.15)
    ]
    corners = [tuple(box[i >> k & 1][k] for k in range(3)) for box in boxes for i in range(8)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    indices = [8 * box + side[i] for box in range(len(boxes)) for side in sides for i in (0, 1, 2, 0, 2, 3)]
    data = struct.pack(f"<{3 * len(corners)}f{len(indices)}H", *sum(corners, ()), *indices)
    views = [
        {"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in ((0, 12 * len(corners)), (12 * len(corners), 2 * len(indices)))
    ]
    text = json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "buffers": [{"byteLength": len(data)}],
            "bufferViews": views,
            "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.35, 0.5, 1], "metallicFactor": 0}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
            "accessors": [
                {
                    "bufferView": 0,
                    "componentType": 5126,
                    "count": len(corners),
                    "type": "VEC3",
                    "min": [-0.2, 0, -0.2],
                    "max": [0.2, 0.45, 0.2],
                },
                {"bufferView": 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"},
            ],
        }
    )
    text += " " * (-len(text) % 4)
    return (
        struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(data), len(text), b"JSON")
        + text.encode()
        + struct.pack("<I4s", len(data), b"BIN\0")
        + data
    )


def prepare(npm, work, readme):
    """The package, the README's examples, a model, and a picture of the room that the program makes up of seed 7 (its own: no licence),
    taken 1.1 m above the floor."""
    package = work / "node_modules/sandglass"
    shutil.rmtree(package, ignore_errors=True)
    shutil.copytree(npm, package)
    for file in HERE.iterdir():
        shutil.copy(file, work)
    light, poured = re.findall(r"```js\n(.*?)```", readme.read_text(), re.DOTALL)[:2]
    sand = light + poured
    check(len(sand.splitlines()) <= 25 and "createSand" in poured, "each example has at most 25 lines")
    for name, text in (("light", light), ("sand", sand)):
        (work / f"{name}.mjs").write_text(text + HANDLES)
    (work / "public").mkdir(exist_ok=True)
    for folder in (work, work / "public"):
        (folder / "model.glb").write_bytes(stool())
        shutil.copy(readme.parents[2] / "models/pictures/room.jpg", folder / "room.jpg")
    page = (HERE / "index.html").read_text()
    names = json.dumps({"imports": {name: f"/node_modules/{path}" for name, path in MAP.items()}})
    (work / "map.html").write_text(page.replace("<!-- import map -->", f'<script type="importmap">{names}</script>'))
    (work / "vite.config.js").write_text('export default { optimizeDeps: { exclude: ["sandglass"] } };\n')


def opened(browser, url):
    browser.open(url)
    end = time.monotonic() + PATIENCE
    while (ready := browser.ask("globalThis.ready ?? ''")) == "" and time.monotonic() < end:
        time.sleep(0.1)
    return ready


def lit(browser, frames, places, photo):
    """The light at places of the floor, of that in the photograph behind it; or of that at the last place."""
    seen, bare = (browser.ask(f"{LOOK}({n}, {json.dumps(places)})") for n in (frames, -1 if photo else 0))
    return [sum(here) / sum(there) for here, there in zip(seen, bare if photo else [bare[-1]] * len(seen))]


def shows(browser, work, how, url, frames=60, places=PLACES, photo=True):
    """The page shows a shadow at the first place, and none at the other."""
    ready = opened(browser, url)
    if ready != "yes":
        check(False, f"{how}: {ready}")
    dark, clear = lit(browser, frames, places, photo)
    browser.screenshot(work / "pictures" / f"{how}.png")
    check(
        0.3 < dark < 0.85 and abs(clear - 1) < 0.05 and browser.ask("gl.getError()") == 0,
        f"{how}: the floor has {dark:.2f} of the light in the shadow, {clear:.2f} beside it",
    )
    return dark


def poured(browser, how, seat, bare):
    """Sand lies on the seat: there red is more than blue, and not on the bare model."""
    on, beside = browser.ask(f"{LOOK}(150, {json.dumps([seat, bare])})")
    particles = browser.ask("stage.drawn.particles")
    check(particles > 100 and on[0] > on[2] and beside[0] < beside[2], f"{how}: sand of {particles} particles on the seat")


def cubes(browser, how):
    right, signs, pi = (browser.ask(f"cube({json.dumps(fault)})") for fault in ("", "signs", "pi"))
    check(
        right <= 0.005 < 0.3 < min(signs, pi),
        f"{how}: worst face of a white cube {right:.2%}; with wrong signs {signs:.0%}, with a sun over pi {pi:.0%}",
    )


def grows(browser):
    """By 96 MiB between two frames."""
    browser.ask("renderer.setAnimationLoop(null); globalThis.held = stage.stage.sand.floats(stage.stage.sand.allocate(16), 4); 0")
    places = json.dumps([[0.05 + 0.1 * (i % 10), 0.05 + 0.1 * (i // 10)] for i in range(100)])
    before = browser.ask(f"{LOOK}(0, {places})")
    browser.ask("stage.stage.sand.allocate(96 << 20)")
    after = browser.ask(f"{LOOK}(0, {places})")
    same = sum(max(abs(a - b) for a, b in zip(one, two)) < 0.02 for one, two in zip(before, after))
    check(
        same >= 95 and browser.ask("gl.getError()") == 0 and browser.ask("held.length") == 0,
        f"memory grew: {same} of 100 pixels are as before; a held view has ended",
    )


def vite(work, look, path="?app=light", more=()):
    """By Vite's own server, which is asked until it answers: what it prints has colours where CI is set."""
    with http.server.HTTPServer(("127.0.0.1", 0), Files) as free:
        port = free.server_port
    url, end = f"http://127.0.0.1:{port}/{path}", time.monotonic() + PATIENCE
    server = subprocess.Popen(
        [
            "node",
            "node_modules/vite/bin/vite.js",
            "--host",
            "127.0.0.1",
            "--port",
            str(port),
            "--strictPort",
            "--force",
            "--logLevel",
            "error",
            *more,
        ],
        cwd=work,
    )
    try:
        while True:
            try:
                urllib.request.urlopen(url, timeout=PATIENCE).close()
                break
            except OSError:
                if server.poll() is not None or time.monotonic() > end:
                    check(False, "Vite does not start")
                time.sleep(0.1)
        look(url)
    finally:
        server.kill()
        server.wait()


def bundle(npm, work):
    """By Vite, and by esbuild, which leaves the module and files of the page to the app."""

    def run(*command):
        subprocess.run(command, cwd=work, check=True, timeout=300)

    run("node", "node_modules/vite/bin/vite.js", "build", "--logLevel", "error", "--outDir", "built", "--emptyOutDir")
    run(
        "node_modules/.bin/esbuild",
        "main.mjs",
        "babylon.mjs",
        "--bundle",
        "--format=esm",
        "--splitting",
        "--outdir=bundled",
        "--log-level=error",
    )
    shutil.copy(npm / "sandglass.wasm", work / "bundled")
    for name in ("main", "babylon"):
        (work / "bundled" / f"{name}.html").write_text((HERE / "index.html").read_text().replace("main.mjs", f"{name}.js"))
    for name in ("model.glb", "room.jpg"):
        shutil.copy(work / name, work / "bundled")


def main(arguments):
    if CHROMIUM is None:
        return SKIPPED
    npm, work, readme = map(pathlib.Path, arguments)
    prepare(npm, work, readme)
    (work / "pictures").mkdir(exist_ok=True)
    bundle(npm, work)
    browser = Browser(CHROMIUM, width=800, height=760, flags=SOFTWARE)
    try:
        plain, built, bundled = served(work), served(work / "built"), served(work / "bundled")
        shows(browser, work, "import map", plain + "map.html?app=light")
        browser.ask("stage.removeModel(model)")
        dark = lit(browser, 120, PLACES, True)[0]
        check(abs(dark - 1) < 0.05, f"without the model's shadow that floor has {dark:.2f} of the light")
        cubes(browser, "three.js")
        shows(browser, work, "import map, sand", plain + "map.html?app=sand", 20)
        poured(browser, "import map", (0.5, 0.66), (0.44, 0.69))
        browser.screenshot(work / "pictures/import map, sand.png")
        grows(browser)
        far = browser.ask(WORKER)
        check(
            far["particles"] > 100 and far["longest"] < far["field"] / 4 and far["adding"] <= 16 and far["frame"] <= 0.5,
            "in a worker: a model of {vertices} vertices takes {adding:.1f} ms of the page, its field {field:.0f} ms of none, longest wait {longest:.0f} ms; a frame takes {frame:.2f} ms".format(
                **far
            ),
        )
        shows(browser, work, "import map", plain + "map.html?app=light")
        found = browser.ask(PLACE)
        white, red, green = [255, 255, 255], [255, 0, 0], [0, 255, 0]
        colours = [found[name] for name in ("plain", "place", "beside", "again", "without")]
        check(colours == [green, white, red, green, red], f"a place hides what is behind it, and is not drawn: {colours}")
        dark, clear = found["dark"], found["lit"]
        check(
            max(dark) - min(dark) < 2 and 20 < dark[0] < clear[0] - 60 and found["error"] == 0,
            f"a shadow falls on it: {dark}, beside {clear}",
        )
        check(
            abs(found["on"] - 0.2) < 0.01 and found["under"] < 0.01,
            "sand lies {on:.3f} m high on it, and {under:.3f} without it".format(**found),
        )
        check(abs(found["seen"] - 0.1) < 0.01, "and {seen:.3f} m high on what an emulated device sees".format(**found))
        shows(browser, work, "vite build", built + "?app=light")
        before, after = browser.ask(ROUNDS)
        check(before == after, f"ten stages leave what the renderer held: {before}, {after}")
        for call, sentence in REFUSED.items():
            told = browser.ask(f"(async () => {call})().catch((error) => error.message)")
            check(sentence in str(told), f"{call}: {told}")
        check(abs(browser.ask(VOLUME) - 6) < 1e-4, "a mirrored model is no hole")
        left = browser.ask("(stage.dispose(), step(), [scene.children.includes(stage.sun), stage.probe.parent !== null, gl.getError()])")
        check(left == [False, False, 0], f"after dispose the scene has no light of the stage, and is drawn: {left}")
        vite(work, lambda url: shows(browser, work, "vite", url))
        shows(browser, work, "esbuild", bundled + "main.html?app=light")
        dark = []
        for hand in ("right", "left"):
            dark += [
                shows(
                    browser,
                    work,
                    f"babylon, {hand}-handed",
                    bundled + f"babylon.html?app={hand}",
                    20,
                    ((0.5, 0.92), (0.1, 0.9)),
                    hand == "right",
                )
            ]
            poured(browser, f"babylon, {hand}-handed", (0.5, 0.66), (0.5, 0.85))
            browser.screenshot(work / "pictures" / f"babylon, {hand}-handed.png")
            found = browser.ask(BABYLON_PLACE)
            # Of what is not drawn there is the photograph; in the other scene, whose floor it hides too, the colour that the picture begins with.
            bare = found["bare"] if hand == "right" else [51, 51, 77]
            near = max(abs(a - b) for a, b in zip(found["place"], bare))
            right = found["post"] == [255, 0, 0] and found["both"] == found["again"] == [0, 255, 0] and found["error"] == 0
            check(right and near <= 8, f"babylon, {hand}-handed: a place hides what is behind it: {found}")
            cubes(browser, f"babylon, {hand}-handed")
        check(abs(dark[0] - dark[1]) < 0.02, "over the photograph a shadow is as dark as on the floor's own material")
    finally:
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
