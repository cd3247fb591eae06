#!/usr/bin/env python3
"""No function and no file is too long to be read at once.

    lengths.py ROOT [MOST]

A function has at most MOST lines in runtime/ and kernels/, 60 if it is not given, and a third more elsewhere, from its name to its
closing brace; a file of code has ten times as many. A lambda is part of its function, a method stands by itself. eslint counts
the functions of JavaScript.
"""

import ast
import pathlib
import re
import sys

FOLDERS = ("platform", "kernels", "runtime", "models", "tests", "toolchains")
CPP = (".cpp", ".h", ".hpp", ".inl")
# Comments, strings and preprocessor lines are left out of the search for braces.
NO_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^[ ]*#(?:[^\n]*\\\n)*[^\n]*', re.DOTALL | re.MULTILINE
)
HOLDER = re.compile(r"\b(?:namespace|struct|class|union|extern)\b[^()=]*$")


def functions(text):
    """(its first line, its head, its number of lines) of each function: of each block with parameters that stands only in holders."""
    text = NO_CODE.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
    inside, head_from = [], 0
    for brace in re.finditer(r"[{};]", text):
        at = brace.start()
        if brace[0] == "{":
            head = text[head_from:at]
            start = head_from + len(head) - len(head.lstrip())
            kind = "holder" if HOLDER.search(head) else "function" if ")" in head else "data"
            inside.append((kind, start, head.strip()))
        elif brace[0] == "}" and inside:
            kind, start, head = inside.pop()
            if kind == "function" and all(outer == "holder" for outer, _, _ in inside):
                first = text.count("\n", 0, start) + 1
                yield first, head.split("\n")[0], text.count("\n", 0, at) + 2 - first
        head_from = at + 1


def functions_of_python(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.lineno, node.name, node.end_lineno - node.lineno + 1


root, most_lines, faults = pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 60, []
for path in sorted(path for folder in FOLDERS for path in (root / folder).rglob("*") if path.suffix in (*CPP, ".mjs", ".mts", ".py")):
    name, text = path.relative_to(root).as_posix(), path.read_text()
    if "/control/" in name or "node_modules" in name:
        continue
    if (lines := text.count("\n")) > (most := 10 * most_lines):
        faults.append(f"{name} has {lines} lines, more than {most}")
    most = most_lines if name.startswith(("runtime/", "kernels/")) else most_lines * 4 // 3
    found = functions(text) if path.suffix in CPP else functions_of_python(text) if path.suffix == ".py" else []
    faults += [f"{name}:{first}: {head}: {lines} lines, more than {most}" for first, head, lines in found if lines > most]
sys.exit("\n".join(faults + [f"{len(faults)} faults: cut by ideas"]) if faults else None)
