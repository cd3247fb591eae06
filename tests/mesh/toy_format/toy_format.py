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


def main():
    source, work = map(pathlib.Path, sys.argv[1:3])
    tree, build, diff = work / "tree", work / "build", (HERE / "toy.diff").read_text()
    parts = re.findall(r"^\+\+\+ b/(\S+)\n(.*?)(?=^diff |\Z)", diff, re.MULTILINE | re.DOTALL)
    if len(parts) > 3:
        sys.exit(f"toy_format.py: a new format touches {len(parts)} files")
    shutil.rmtree(work, ignore_errors=True)
    for folder in ("models/mesh", "tests/mesh"):
        shutil.copytree(source / folder, tree / folder)
    subprocess.run(["git", "apply", HERE / "toy.diff"], cwd=tree, check=True, env={**os.environ, "GIT_CEILING_DIRECTORIES": str(work)})
    subprocess.run(["cmake", "-S", HERE, "-B", build, "-G", "Ninja", f"-DTREE={tree}", f"-DSOURCE={source}", *sys.argv[3:]], check=True)

    def passes():
        built = subprocess.run(["cmake", "--build", build], stderr=subprocess.STDOUT)
        return built.returncode == 0 and subprocess.run([build / "kinds", f"--gtest_filter={CASES}"]).returncode == 0

    if not passes():
        sys.exit("toy_format.py: the toy format is not read")
    for name, part in sorted(parts):
        before, line = re.findall(r"(?:^-(.*\n))?^\+(.*toy.*\n)", part, re.MULTILINE)[-1]
        text = (tree / name).read_text()
        (tree / name).write_text(text.replace(line, before))
        if passes():
            sys.exit(f"toy_format.py: {name} need not say: {line}")
        (tree / name).write_text(text)


main()
