#!/usr/bin/env python3
"""Puts the page into one file: python3 assemble.py NPM_FOLDER PAGE_FOLDER SCENE_JSON OUTPUT

The modules are joined in the order of their imports, without import and export, into the page's one script. The
library, compressed, and the scene go in as text. The page then needs nothing but itself; the library with threads, which
a page asks for where a server lets it run them, is put beside it."""

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
    modules = {"k_module": npm / "sandglass.wasm", "k_mesh_module": parts / "mesh_reader.wasm", "k_block_module": parts / "sand_block.wasm"}
    packed = {name: zlib.compress(file.read_bytes(), 9) for name, file in modules.items()}
    data = "".join(f'const {name} = "{base64.b64encode(content).decode()}";\n' for name, content in packed.items())
    data += f"const k_scene = {json.dumps(json.loads(scene.read_text()))};\n"
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
                    "stage_shadows",
                    "stage",
                    "sand_block",
                    "loose_sand",
                    "sand_painter",
                    "glsl",
                )
            ),
            parts / "meshopt_decoder.mjs",
            *(here / f"{name}.mjs" for name in own),
        ]
    )
    readers = sorted(path for path in (here.parent / "mesh/readers").glob("*.cpp") if path.stem != "assimp")
    endings = [re.search(r"MeshFormat k_\w+ = {\s*\"[^\"]*\", \"([^\"]*)\"", path.read_text())[1] + "," for path in readers]
    page = (here / "page.html").read_text().replace("@MESHES@", "".join(endings)).replace("@MODULES@", data + script)
    if "</script" in (data + script):
        sys.exit("assemble.py: a module holds the end of a script")
    output.write_text(page)
    shutil.copy(npm / THREADS, output.parent / THREADS)
    print(output.resolve())


if __name__ == "__main__":
    main()
