"""The names of before are found by toolchains/rename.py: rename_test.py SOURCE WORK_FOLDER COMPILER LIBRARY

before/examples.diff, taken back, makes the examples of the version before. With the script applied to them, they are those of now, or
build and print the same."""

import os
import pathlib
import shutil
import subprocess
import sys

source, work, compiler, library = (pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve(), sys.argv[3], sys.argv[4])


def run(*command, cwd=None):
    apart = {**os.environ, "GIT_CEILING_DIRECTORIES": str(work.parent)}  # git applies nothing to what another repository ignores
    return subprocess.run([str(word) for word in command], cwd=cwd, env=apart, check=True, stdout=subprocess.PIPE, text=True).stdout


def says(file, made):
    """What an example prints."""
    language = ["-x", "c", "-std=c99"] if file.suffix == ".c" else ["-std=c++20"]
    run(
        compiler,
        "-O1",
        *language,
        "-I",
        source / "runtime/include",
        "-I",
        source,
        file,
        "-x",
        "none",
        library,
        "-lstdc++",
        "-lm",
        "-o",
        made,
    )
    return run(made, *([source / "models/shadows/chair.shadow"] if file.stem == "shadow_alone" else []))


shutil.rmtree(work, ignore_errors=True)
shutil.copytree(source / "models/examples", work / "models/examples")
run("git", "apply", "-R", "--recount", source / "tests/package/before/examples.diff", cwd=work)
before = {
    file.name for file in (work / "models/examples").iterdir() if file.read_bytes() != (source / "models/examples" / file.name).read_bytes()
}
changed = {pathlib.Path(line).name for line in run(sys.executable, "-B", source / "toolchains/rename.py", work).splitlines()}
if before != changed or len(before) < 3:
    sys.exit(f"rename_test.py: {sorted(before)} have names of before, {sorted(changed)} were changed")
for name in sorted(before):
    old, new = work / "models/examples" / name, source / "models/examples" / name
    if old.read_bytes() == new.read_bytes():
        continue
    then, now = says(old, work / "then"), says(new, work / "now")
    if then != now:
        sys.exit(f"rename_test.py: {name} prints something else:\n{then}\n{now}")
