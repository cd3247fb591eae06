#!/usr/bin/env python3
"""What trimesh reads of the mesh files in a folder: other_reader.py FOLDER

A line a file, its fields separated by tabs: name; the box along x, y and z; area; volume; triangles. A file that trimesh
refuses has its name and why. Exit code 3: there is no trimesh here."""
import pathlib
import sys

try:
    import trimesh
except ImportError:
    sys.exit(3)

ENDINGS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".off", ".dae")


def told(path):
    mesh = trimesh.load(path, force="mesh", process=False)
    numbers = [*mesh.extents, mesh.area, mesh.volume]
    return "\t".join(f"{number:.9g}" for number in numbers) + f"\t{len(mesh.faces)}"


def main():
    folder = pathlib.Path(sys.argv[1])
    for path in sorted(path for path in folder.rglob("*") if path.suffix.lower() in ENDINGS and path.is_file()):
        try:
            said = told(path)
        except Exception as error:  # whatever it is, the file is one that trimesh does not read
            said = " ".join(f"{type(error).__name__} {error}".split())[:100]
        print(path.relative_to(folder), said, sep="\t", flush=True)


main()
