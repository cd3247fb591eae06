#!/usr/bin/env python3
"""No function of Python has more than 80 lines, and no file more than 600. eslint counts those of JavaScript.

lengths.py ROOT [LINES OF A FUNCTION]
"""

import ast
import pathlib
import sys

FILE = 600
LEFT_OUT = {".git", "build", "out", "node_modules"}


def faults(root, most):
    for path in sorted(root.rglob("*.py")):
        inside = path.relative_to(root)
        if LEFT_OUT.intersection(inside.parts):
            continue
        text = path.read_text()
        lines = len(text.splitlines())
        if lines > FILE:
            yield f"{inside} has {lines} lines, more than {FILE}"
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                continue
            lines = node.end_lineno - node.lineno + 1
            if lines > most:
                yield f"{inside}:{node.lineno}: {node.name} has {lines} lines, more than {most}"


if __name__ == "__main__":
    found = list(faults(pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 80))
    sys.exit("\n".join([*found, f"{len(found)} faults"]) if found else None)
