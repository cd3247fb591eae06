#!/usr/bin/env python3
"""The tree has a budget: how many lines of code each folder may have, and words the documents together.

bars.py check ROOT    fails where a folder has more lines than bars.txt says, or no line there
bars.py write ROOT    writes what is there now: who lets a folder grow commits its new bar with it
"""

import collections
import pathlib
import re
import sys

CODE = re.compile(
    r"(\.(c|cpp|h|hpp|inl|inc|in|py|mjs|cjs|js|mts|ts|cs|java|kt|mm|m|swift|cmake|sh|html|css|glsl|vert|frag|metal|hlsl|shader|mat|fbs|gradle)"
    r"|(^|/)(CMakeLists\.txt|Snakefile|sg|run))$"
)
LEFT_OUT = {".git", "build", "out", "node_modules", "__pycache__"}


def count(root):
    lines = collections.Counter()
    for path in root.rglob("*"):
        inside = path.relative_to(root)
        if LEFT_OUT.intersection(inside.parts) or not path.is_file():
            continue
        if inside.suffix == ".md":
            lines["words"] += len(path.read_text().split())
        elif CODE.search(inside.as_posix()):
            lines["/".join(inside.parts[:-1][:2]) or "."] += path.read_bytes().count(b"\n")
    return lines


def main():
    task, root = sys.argv[1], pathlib.Path(sys.argv[2])
    there, file = count(root), root / "tests/docs/bars.txt"
    if task == "write":
        file.write_text("".join(f"{lines:6} {folder}\n" for folder, lines in sorted(there.items())))
        return 0
    bars = {folder: int(lines) for lines, folder in (line.split() for line in file.read_text().splitlines())}
    faults = [
        f"{folder} has {lines}, and its bar is {bars.get(folder, 0)}"
        for folder, lines in sorted(there.items())
        if lines > bars.get(folder, 0)
    ]
    return "\n".join([*faults, f"{len(faults)} faults: take lines away, or commit the new bar (bars.py write .)"]) if faults else 0


if __name__ == "__main__":
    sys.exit(main())
