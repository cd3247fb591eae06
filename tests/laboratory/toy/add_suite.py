"""A suite is three files: suite.patch adds one to a copy of the tree.

add_suite.py ROOT BUILD [--without TEXT] [OPTIONS of CMake]   TEXT: added lines that have it are left out

Fails where the patch touches more files, or the program does not list the suite, run it, and have its numbers kept. Only
what the patch changes is compiled; the rest is that of BUILD.
"""

import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile


def run(*command, cwd=None, text=None):
    done = subprocess.run(command, cwd=cwd, input=text, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))[:200]}\n{done.stdout}\nended with {done.returncode}")
    return done.stdout


def build(tree, old, sources, options):
    """The program of the tree: these sources, and the other objects of the old build."""
    new = tree / "build" / "host"
    run("cmake", "--preset", "host", "-DBUILD_TESTING=ON", *options, cwd=tree)
    link = run("ninja", "-C", new, "-t", "commands", "bin/sandglass_lab").splitlines()[-1]
    objects = [word for word in link.split() if any(word.endswith(f"sandglass_lab.dir/{source}.o") for source in sources)]
    run("ninja", "-C", new, "-j1", *objects)
    (new / "bin").mkdir(exist_ok=True)
    for made in [*objects, "bin/sandglass_lab"]:
        link = link.replace(f" {made} ", f" {new / made} ")
    run("sh", "-c", link, cwd=old)
    return new / "bin" / "sandglass_lab"


def check(tree, root, old, without, options):
    shutil.copytree(root, tree, ignore=shutil.ignore_patterns(".git", "build", "out"))
    patch = (pathlib.Path(__file__).parent / "suite.patch").read_text().splitlines(keepends=True)
    patch = "".join(line for line in patch if not (without and line[0] == "+" and without in line))
    apply = ["git", "apply", "--recount"]
    touched = [line.split()[-1] for line in run(*apply, "--numstat", "-", cwd=tree, text=patch).splitlines()]
    if len(touched) > 3:
        sys.exit(f"a suite touches {len(touched)} files: {' '.join(touched)}")
    run(*apply, "-", cwd=tree, text=patch)
    lab = build(tree, old, ["lab.cpp", *(pathlib.Path(file).name for file in touched if file.endswith(".cpp"))], options)
    if "toy       Sums" not in run(lab, "verify", "--help"):
        sys.exit("the help lists no toy")
    if "1 rows, 0 failed" not in run(lab, "verify", "toy"):
        sys.exit("the suite shows no row")
    run(sys.executable, "tests/docs/numbers.py", "measure", ".", "verify_toy", cwd=tree)
    kept = json.loads((tree / "models/numbers/verify_toy.json").read_text())
    if kept.get("rows", {}).get("two and two", {}).get("result") != 4:
        sys.exit(f"its numbers are not kept: {kept}")
    print(f"{len(touched)} files: {' '.join(touched)}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--without", default="")
    arguments, options = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder:
        check(pathlib.Path(folder) / "tree", arguments.root, arguments.build, arguments.without, options)


if __name__ == "__main__":
    main()
