#!/usr/bin/env python3
"""What tests take from the public headers: python3 header_facts.py INCLUDE_FOLDER OUTPUT_FOLDER POINTER_BYTES

Writes to OUTPUT_FOLDER:
  layout.c        a claim for each size and offset, for every language that has the headers
  arguments.inc   the names of the arguments of each function that has a pointer among them, for arguments_test.cpp
  handles.inc     functions that take one pointer and nothing else; and what is made by a description alone
It refuses headers in which a function has more than 7 parameters.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "toolchains/bindings"))
from headers import Headers  # noqa: E402

headers, output = Headers(sys.argv[1]), pathlib.Path(sys.argv[2])
(output / "layout.c").write_text(headers.claims(int(sys.argv[3])))
if wide := [name for name, function in headers.functions.items() if len(function.parameters) > 7]:
    sys.exit(f"more than 7 parameters, so these take a desc struct: {', '.join(wide)}")
rows = [
    f'{{"{name}", {{{", ".join(chr(34) + item.name + chr(34) for item in function.parameters)}}}}},\n'
    for name, function in headers.functions.items()
    if any(item.pointer for item in function.parameters)
]
(output / "arguments.inc").write_text("".join(rows))
made = [
    f"ONE_POINTER({name}, {function.parameters[0].base})\n"
    for name, function in headers.functions.items()
    if len(function.parameters) == 1 and function.parameters[0].pointers == 1
]
for name in headers.handles:
    described = [headers.functions.get(name + verb) for verb in ("_desc_default", "_bytes", "_create")]
    if all(described) and [len(function.parameters) for function in described] == [1, 3, 5]:
        made.append(f"MADE_ALONE({name})\n")
(output / "handles.inc").write_text("".join(made))
