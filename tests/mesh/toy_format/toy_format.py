#!/usr/bin/env python3
"""A new mesh format touches three files, and needs each of them: toy_format.py SOURCE WORK_FOLDER CMAKE_ARGUMENTS...

toy.diff adds one: its reader, its place in the list, its test case. The mesh library and its test are built in a copy of
the tree with that diff. The test passes there, and fails wherever the last line of a file that names the toy is as it was
before."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
CASES = "MeshKinds.EveryFormatHasAFile:MeshKinds.AreReadRightOrRefusedWithTheReason"


def quiet(command, **more):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)


def main():
    source, work = map(pathlib.Path, sys.argv[1:3])
    tree, build, diff = work / "tree", work / "build", (HERE / "toy.diff").read_text()
    parts = re.findall(r"^\+\+\+ b/(\S+)\n(.*?)(?=^diff |\Z)", diff, re.MULTILINE | re.DOTALL)
    if len(parts) > 3 or len(parts) != len(re.findall("^diff ", diff, re.MULTILINE)):
        sys.exit(f"toy_format.py: a new format touches {len(parts)} files")
    shutil.rmtree(work, ignore_errors=True)
    for folder in ("models/mesh", "tests/mesh"):
        shutil.copytree(source / folder, tree / folder)
    subprocess.run(["git", "apply", HERE / "toy.diff"], cwd=tree, check=True, env={**os.environ, "GIT_CEILING_DIRECTORIES": str(work)})
    without = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in ("assimp", "draco", "meshoptimizer")]
    configured = quiet(["cmake", "-S", HERE, "-B", build, "-G", "Ninja", f"-DTREE={tree}", f"-DSOURCE={source}", *without, *sys.argv[3:]])
    if configured.returncode != 0:
        sys.exit(configured.stdout)

    def result():
        built = quiet(["cmake", "--build", build])
        return built if built.returncode != 0 else quiet([build / "kinds", f"--gtest_filter={CASES}"])

    whole = result()
    if whole.returncode != 0:
        sys.exit(whole.stdout)
    for name, part in sorted(parts):
        before, line = re.findall(r"(?:^-(.*\n))?^\+(.*toy.*\n)", part, re.MULTILINE)[-1]
        file = tree / name
        text = file.read_text()
        file.write_text(text.replace(line, before))
        if result().returncode == 0:
            sys.exit(f"toy_format.py: {name} need not say: {line}")
        file.write_text(text)
    print(f"a new format touches {', '.join(name for name, _ in parts)}")


main()
