#!/usr/bin/env python3
"""What the library refuses with is a sentence: it ends in a full stop, and does not begin with the function's name.

sentences.py ROOT
"""

import pathlib
import re
import sys

TEXT = r'"(?:\\.|[^"\\\n])*"'
CALL = re.compile(rf'\brefuse\((?:[^()";]|\([^()"]*\)|(?P<text>{TEXT}(?:\s*{TEXT})*))*\)')
GIVEN = re.compile(rf"return (?:\w+ == nullptr \? )?(?P<text>{TEXT}(?:\s*{TEXT})*);")

root, faults = pathlib.Path(sys.argv[1]), []
for path in sorted((root / "runtime").rglob("*.cpp")) + sorted((root / "runtime").rglob("*.h")):
    code = path.read_text()
    for found in [*CALL.finditer(code), *GIVEN.finditer(code)]:
        said = "".join(part[1:-1] for part in re.findall(TEXT, found["text"] or ""))
        if " " in said.strip() and said != "unknown status" and (not re.search(r"[.!?]$", said) or re.match(r"sandglass_\w+: ", said)):
            faults.append(f"{path.relative_to(root)}:{code.count(chr(10), 0, found.start()) + 1}: {said}")
sys.exit("\n".join([*faults, f"{len(faults)} faults"]) if faults else None)
