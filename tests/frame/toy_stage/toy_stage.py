#!/usr/bin/env python3
"""A new stage of the frame touches six files, and needs each of them: toy_stage.py SOURCE WORK_FOLDER CMAKE_ARGUMENTS...

toy.diff adds one to a copy of the tree: its header and source, its number and its field of the frame's input, its row in
the table, its owner in C++, a line for users. What is built there must know its name: report, trace, page, recording,
reference, owner, web binding, table of NULLs, fuzzer. Where a line that names the toy is taken away again, something fails.
And nothing else in the tree lists the stages."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
TARGETS = ["sandglass_toy_tests", "package_api", "fuzz_frame"]
# One of these in the copy, each by the file that has it: without it the stage cannot be whole.
LINES = {
    "runtime/frame/capabilities.inc": ["STAGE(TOY", "ONE(TOY"],
    "runtime/include/sandglass/frame.h": ["STAGE_TOY = 5", "sandglass_toy* toy"],
    "runtime/include/sandglass/sandglass.hpp": ["class Toy"],
}


def run(*command, cwd=None, fails=False):
    done = subprocess.run([str(word) for word in command], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode and not fails:
        sys.exit(f"{done.stdout[-8000:]}\ntoy_stage.py: this failed: {command[0]}")
    return None if done.returncode else done.stdout


def copied(source, tree):
    """The tree with the diff; its files."""
    shutil.copytree(source, tree, ignore=shutil.ignore_patterns(".git", "build", "out", "node_modules", "numbers", "pictures"))
    (tree / "tests/toy").mkdir()
    shutil.copyfile(HERE / "toy_stage_test.cpp", tree / "tests/toy/toy_stage_test.cpp")
    (tree / "tests/toy/CMakeLists.txt").write_text("sandglass_test(sandglass_toy_tests LIBRARIES models_report)\n")
    apply = ["git", "apply", "--recount"]
    subprocess.run([*apply, HERE / "toy.diff"], cwd=tree, check=True, env={**os.environ, "GIT_CEILING_DIRECTORIES": str(tree.parent)})
    return re.findall(r"^\+\+\+ b/(\S+)", (HERE / "toy.diff").read_text(), re.MULTILINE)


def passes(build):
    """What the programs say, or None. The table's own file comes first: most of what is missing is missing there."""
    first = [f"runtime/CMakeFiles/sandglass_runtime.dir/scene/{name}.cpp.o" for name in ("frame", "names")]
    if any(run("ninja", "-C", build, *targets, fails=True) is None for targets in (first, TARGETS[:1])):
        return None
    return run(build / "tests/toy/sandglass_toy_tests", fails=True)


def expect(where, text):
    if "toy" not in text.lower():
        sys.exit(f"toy_stage.py: {where} does not know the toy")


def names(tree, build, work, node):
    """Each place where the toy must stand without a line of its own."""
    run("ninja", "-C", build, *TARGETS)
    run(build / "tests/package/package_api", "--gtest_filter=Arguments.*")
    expect("the table of NULLs", (build / "tests/package/handles.inc").read_text())
    expect("the fuzzer", run("nm", "-C", build / "tests/fuzz/fuzz_frame"))
    run(build / "tests/fuzz/fuzz_frame", tree / "tests/fuzz/corpus/frame")
    run(sys.executable, "-B", tree / "toolchains/bindings/web.py", tree / "runtime/include", work)
    expect("the web binding", (work / "abi.mjs").read_text())
    for name, text in (
        ("measure.mjs", (tree / "models/page/measure.mjs").read_text()),
        ("scene.mjs", "export class SandScene {}"),
        ("data.mjs", "export const k_scene = {};"),
        ("sandglass.mjs", 'export { constants } from "./abi.mjs";'),
    ):
        (work / name).write_text(text)
    said = re.findall(r"^stage (\w+)", passes(build), re.MULTILINE)
    script = f"import {{ stagesOf }} from './measure.mjs'; console.log(stagesOf({{ sandglass_stage_name: (i) => {said}[i] }}).map(({{ name }}) => name).join());"
    bars = run(node, "--input-type=module", "-e", script, cwd=work).strip()
    if bars != ",".join(said):
        sys.exit(f"toy_stage.py: the page has bars for {bars}, the library's stages are {said}")
    expect("the page", bars)
    (tree / "build").mkdir(exist_ok=True)
    if shutil.which("doxygen"):
        (tree / "build/docs").mkdir()
        run("doxygen", "toolchains/docs/Doxyfile", cwd=tree)
        expect("the reference", "".join(path.name for path in (tree / "build/docs/html").glob("*toy*")))


def lists(source):
    """Where else a line names three stages or more as strings, or one by its number: "light" and "shadow" are words, too. The frame's
    own tests make up stages."""
    table = ["granular", *re.findall(r'STAGE\(\w+, "(\w+)"', (source / "runtime/frame/capabilities.inc").read_text()), "refine", "output"]
    found = []
    for top in ("kernels", "runtime", "models", "toolchains", "tests"):
        for path in (source / top).rglob("*"):
            if path.suffix in (".cpp", ".h", ".inc", ".mjs", ".mts", ".py", ".html") and source / "tests/frame" not in path.parents:
                for line in path.read_text().splitlines():
                    if sum(f'"{name}"' in line for name in table) > 2 or re.search(r"\bstages\[\d", line):
                        found.append(f"{path.relative_to(source)}: {line.strip()}")
    return found


def main():
    source, work, node = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
    tree, build = work / "tree", work / "build"
    if found := lists(source):
        sys.exit("toy_stage.py: stages are listed in\n" + "\n".join(found))
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    files = copied(source, tree)
    if len(files) > 6:
        sys.exit(f"toy_stage.py: a new stage touches {len(files)} files")
    run(
        "cmake",
        "-S",
        tree,
        "-B",
        build,
        "-G",
        "Ninja",
        "-DBUILD_TESTING=ON",
        "-DCMAKE_BUILD_TYPE=Debug",
        "-DCMAKE_CXX_FLAGS_DEBUG=-O0",
        "-DSANDGLASS_SCALAR_ONLY=ON",
        *sys.argv[4:],
    )
    if passes(build) is None:
        sys.exit("toy_stage.py: the toy stage is not run, reported, traced and recorded:\n" + run("ninja", "-C", build, *TARGETS))
    names(tree, build, work, node)
    for name, starts in LINES.items():
        text = (tree / name).read_text()
        for start in starts:
            (tree / name).write_text("".join(line for line in text.splitlines(keepends=True) if start not in line))
            if passes(build) is not None:
                sys.exit(f"toy_stage.py: {name} need not say {start}")
        (tree / name).write_text(text)
    print(f"{len(files)} files: {' '.join(files)}")


main()
