#!/usr/bin/env python3
"""Each part of a state is changed by the files that its header names, and by those that put the whole together.

    parts.py FOLDER STATE

Below "// ---- Part (file.cpp; other.cpp)" a header of FOLDER has struct Part, and STATE has it as a member. Faults are, in a file that
neither the part names nor WHOLE:
  a parameter Part* part that is written to: part->field = ..., and += and the like, ++ and --
  a parameter STATE* without const
RECORDS are what all files work on. What is written through a reference to a part is not seen.
"""

import pathlib
import re
import sys

WHOLE = {"stage.cpp", "create.cpp", "compare.cpp", "versions.cpp"}
RECORDS = {"records", "nodes"}
FIELD = r"(?:(?:->|\.)\w+|\[[^][]*(?:\[[^][]*\][^][]*)*\])*"
WRITES = [
    r"\b(\w+)->(\w+)" + FIELD + r"\s*(?:[-+*/|&^]|<<|>>)?=(?!=)",
    r"(?:\+\+|--)(\w+)->(\w+)",
    r"\b(\w+)->(\w+)" + FIELD + r"(?:\+\+|--)",
]


def faults(path, owners, state):
    kinds = {}
    for number, line in enumerate(path.read_text().splitlines(), 1):
        code = line.split("//")[0]
        if re.search(rf"(?<!const )\b{state}\* \w+[,)]", code):
            yield f"{path.name}:{number}: takes the whole: {code.strip()}"
        kinds.update({name: kind for kind, name in re.findall(r"(?<!const )\b(\w+)\* (\w+)[,)]", code)})
        for write in WRITES:
            for name, field in re.findall(write, code):
                if path.name not in owners.get(kinds.get(name), {path.name}) and field not in RECORDS:
                    yield f"{path.name}:{number}: {kinds[name]} is of {' and '.join(sorted(owners[kinds[name]]))}: {code.strip()}"


folder, state = pathlib.Path(sys.argv[1]), sys.argv[2]
text = "\n".join(header.read_text() for header in sorted(folder.glob("*.h")))
owners = {part: set(re.findall(r"\w+\.cpp", files)) for part, files in re.findall(r"^// ---- (\w+) \((.*)\)$", text, re.MULTILINE)}
missing = [
    f"{state} has no {part}"
    for part in owners
    if not re.search(rf"^struct {state} \{{.*?^  {part} \w+[;\[]", text, re.MULTILINE | re.DOTALL)
]
found = missing + [fault for path in sorted(folder.glob("*.cpp")) if path.name not in WHOLE for fault in faults(path, owners, state)]
sys.exit("\n".join(found + [f"{len(found)} faults"]) if found or not owners else None)
