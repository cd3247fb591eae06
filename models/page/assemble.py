#!/usr/bin/env python3
"""Puts the page into one file: python3 assemble.py NPM_FOLDER PAGE_FOLDER SCENE_JSON OUTPUT

The modules are joined in the order of their imports, without import and export, into the page's one script. The
library and what else is data stand before it, compressed, as text that no compiler reads. All is ASCII: a browser reads
other text as characters of two bytes, in twice the time. The page then needs nothing but itself; the library with threads,
which a page asks for where a server lets it run them, is put beside it."""

import base64
import json
import pathlib
import re
import shutil
import sys
import zlib

THREADS = "sandglass-threads.wasm"


def joined(paths):
    """The modules as one script. Names must differ between them, and an import must not rename."""
    out, names = [], {}
    for path in paths:
        text = path.read_text()
        if re.search(r"^import [^;]*\bas\b", text, re.MULTILINE):
            sys.exit(f"assemble.py: {path.name} renames what it imports")
        text = re.sub(r"^import \{[^;]*?\} from \"\./[\w.]+\";\n", "", text, flags=re.MULTILINE)
        text = re.sub(r"^export \{[^}]*\}(?: from [^;]*)?;\n", "", text, flags=re.MULTILINE)
        text = re.sub(r"^export ", "", text, flags=re.MULTILINE)
        for name in re.findall(r"^(?:const|let|class|function|async function) (?:\[[^\]]*\]|(\w+))", text, re.MULTILINE):
            if name in names:
                sys.exit(f"assemble.py: {path.name} and {names[name]} both have a {name}")
            names[name] = path.name
        out.append(f"// {path.name}\n{text}")
    return "\n".join(out)


def main():
    npm, parts, scene, output = map(pathlib.Path, sys.argv[1:])
    here = pathlib.Path(__file__).parent
    packed = (
        npm / "sandglass.wasm",
        *(parts / name for name in ("hourglass.bin", "mesh_reader.wasm", "meshopt_decoder.mjs", "sand_block.wasm")),
    )
    texts = {file.stem: base64.b64encode(zlib.compress(file.read_bytes(), 9)).decode() for file in packed}
    data = "".join(f'<script type="text/plain" id="{name}">{text}</script>\n' for name, text in texts.items())
    scene_text = f"const k_scene = {json.dumps(json.loads(scene.read_text()))};\n"
    own = (
        "elements",
        "scene",
        "painter",
        "mesh_file",
        "hourglass",
        "link",
        "pace",
        "tilt",
        "room_light",
        "real_table",
        "measure",
        "stands",
        "objects",
        "recording",
        "controls",
        "readout",
        "loaded",
        "page",
    )
    script = joined(
        [
            *(
                npm / f"{name}.mjs"
                for name in (
                    "abi",
                    "sandglass",
                    "kit",
                    "skin_changes",
                    "options",
                    "mesh_field",
                    "place_light",
                    "webxr",
                    "stage_hands",
                    "stage_place",
                    "stage_shadows",
                    "stage",
                    "sand_block",
                    "loose_sand",
                    "sand_painter",
                    "glsl",
                )
            ),
            *(here / f"{name}.mjs" for name in own),
        ]
    )
    readers = sorted(path for path in (here.parent / "mesh/readers").glob("*.cpp") if path.stem != "assimp")
    endings = [re.search(r"MeshFormat k_\w+ = {\s*\"[^\"]*\", \"([^\"]*)\"", path.read_text())[1] + "," for path in readers]
    script = re.sub(r"[^\0-\x7f]", lambda found: f"\\u{ord(found[0]):04x}", scene_text + script)
    if "</script" in script:
        sys.exit("assemble.py: a module holds the end of a script")
    page = (here / "page.html").read_text().replace("@MESHES@", "".join(endings)).replace("@DATA@\n", data).replace("@MODULES@", script)
    output.write_bytes(page.encode("ascii", "xmlcharrefreplace"))
    shutil.copy(npm / THREADS, output.parent / THREADS)
    print(output.resolve())


if __name__ == "__main__":
    main()
