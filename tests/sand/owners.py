#!/usr/bin/env python3
"""Each part of Granular is changed by the file that owns it. Prints the writes into another part's fields.

    owners.py FOLDER [FILE...]

The headers say who owns what: below "// ---- Type (file.cpp)" stand the types of file.cpp, and a member of Granular that has no such
type is granular.cpp's. Faults are, in any other file of the folder and in each FILE:
  g->part.field = ..., and += and the like, ++ and --
  Part& p = g->part.field and Part* p = &g->part.field without const, and &g->part.field as an argument
  Granular* without const, but in the files that put the whole together (WHOLE)
The records of particles and grains are what all of them work on.
"""

import pathlib
import re
import sys

WHOLE = {"granular", "edit_bodies", "edit_sand", "edit_scene", "substep", "sweep"}
RECORDS = r"(particles\.records|grains\.records|grains\.snapshot\.particles)\b"
PART = r"\b(?:g|granular)(?:->|\.)(?P<part>\w+)"
FIELD = r"(?:(?:->|\.)\w+|\[[^][]*(?:\[[^][]*\][^][]*)*\])"
FAULTS = [
    PART + FIELD + r"*\s*(?:[-+*/|&^]|<<|>>)?=(?!=)",
    r"(?:\+\+|--)\s*" + PART + FIELD + "*",
    PART + FIELD + r"*\s*(?:\+\+|--)",
    r"^\s*(?!const\b)\w+[&*] \w+ = &?" + PART + FIELD + "*",
    r"[(,] ?&g->(?P<part>\w+)" + FIELD + "+",
]


def owners(folder):
    """The file that owns each member of Granular."""
    owner, files = {}, {}
    for header in sorted(folder.glob("*.h")):
        section = None
        for line in header.read_text().splitlines():
            section = m[1] if (m := re.match(r"// ---- .*\((\w+)\.cpp\b", line)) else section
            if m := re.match(r"struct (\w+) \{", line):
                owner[m[1]] = section
    whole = re.search(r"^struct Granular \{(.*?)^\};", (folder / "granular.h").read_text(), re.MULTILINE | re.DOTALL)[1]
    for kind, names in re.findall(r"^  (?:const )?(\w+)[*&]? ([\w\[\], ]+);", whole, re.MULTILINE):
        for name in re.findall(r"[a-z]\w*", names):
            files[name] = owner.get(kind) or "granular"
    return files


def faults(path, files):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        code = line.split("//")[0]
        if re.search(r"(?<!const )\bGranular\s*[*&]\s*\w", code) and path.suffix == ".cpp" and path.stem not in WHOLE:
            yield f"{path.name}:{number}: takes the whole: {code.strip()}"
        for fault in FAULTS:
            for m in re.finditer(fault, code):
                if files.get(m["part"], path.stem) != path.stem and not re.search(RECORDS, m[0]):
                    yield f"{path.name}:{number}: {files[m['part']]}.cpp owns {m['part']}: {code.strip()}"


folder = pathlib.Path(sys.argv[1])
paths = sorted(folder.glob("*.cpp")) + [pathlib.Path(name) for name in sys.argv[2:]]
found = [fault for path in paths for fault in faults(path, owners(folder))]
sys.exit("\n".join(found + [f"{len(found)} faults"]) if found else None)
