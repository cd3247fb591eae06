#!/usr/bin/env python3
"""C++ has one statement a line: commas.py ROOT shows each comma that joins two expressions.

Left alone are declarations, the step of a for loop, and what folds and the arguments of templates separate.
"""

import pathlib
import re
import sys

LEFT_OUT = {".git", "build", "out", "control", "node_modules"}
SUFFIXES = {".c", ".cpp", ".h", ".inc", ".inl", ".m", ".mm"}
SILENT = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'|'
    r"__attribute__\(\((?:[^()]|\([^()]*\))*\)\)|^ *#(?:\\\n|[^\n])*",
    re.S | re.M,
)
TOKEN = re.compile(r"operator\W+?(?=\()|\w+|::|->|\+\+|--|<<|[<>]=|\.\.\.|\S")
BRACKETS = {"(": "()", "[": "[]", "{": "{}"}
HEAD = re.compile(r"((if|for|while|switch|else|do|constexpr|alignas|case .*? :|default :|public :|private :|\[\]|extern) (\(\) )?)+")
SEPARATED = re.compile(r"< (?:[\w:,*&()\[\]{}. ]|<>)*>|\.\.\. ,|, \.\.\.")
DECLARATION = re.compile(
    r"(?!(return|throw|delete|co_return)\b)(@|(auto|class|const|constexpr|enum|static|struct|template|union|using)\b|"
    r"(:: )?(\w+ )+(:: \w+ |<> |[*&] |const )*(?<=\w |> |\* |& )\w+ [=,;({[])"
)
GROUPS = re.compile(r"(if|while|switch|return|[-=(,;{?:+/<|!])$")  # what stands before a bracket that is no call's
AFTER_BLOCK = re.compile(r"[\w{}]|\+\+|--|::")


def joined(part):
    """Whether a statement, its brackets emptied, joins expressions."""
    part = re.sub(f"^{HEAD.pattern}", "", " ".join(part) + " ")
    while part != (part := SEPARATED.sub("<>", part)):
        pass
    return "," in part and not DECLARATION.match(part + ";")


def faults(code):
    """Where statements end that do, in a text whose strings and comments are blank."""
    tokens, before, parts, previous = list(TOKEN.finditer(code)), [], [[]], ""
    for token, following in zip(tokens, [*[next_token[0] for next_token in tokens[1:]], ""]):
        if token[0] in BRACKETS:
            before.append((previous, token[0]))
            parts.append([])
        elif token[0] in ")]}":
            part, (head, bracket) = parts.pop(), before.pop()
            if bracket == "(" and GROUPS.match(head) and joined(["return", *part]):
                yield token.start()
            parts[-1].append(BRACKETS[bracket])
            if bracket == "{" and AFTER_BLOCK.match(following) and parts[-1][0] not in ("class", "enum", "struct", "union"):
                parts[-1] = []
        elif token[0] == ";":
            if joined(parts[-1]):
                yield token.start()
            parts[-1] = []
        else:
            parts[-1].append(token[0])
        previous = token[0]


def blank(found):
    return ("0" if found[0][0] in "R\"'" else " ") + re.sub(r"[^\n]", " ", found[0][1:])


if __name__ == "__main__":
    shown = []
    for path in sorted(pathlib.Path(sys.argv[1]).rglob("*")):
        inside = path.relative_to(sys.argv[1])
        if path.suffix in SUFFIXES and not LEFT_OUT.intersection(inside.parts):
            code = SILENT.sub(blank, path.read_text(encoding="utf-8"))
            shown += [f"{inside}:{code.count(chr(10), 0, at) + 1}: a comma joins two statements" for at in faults(code)]
    sys.exit("\n".join([*shown, f"{len(shown)} faults"]) if shown else 0)
