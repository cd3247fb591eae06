#!/usr/bin/env python3
"""An app's sources in the names of this version: rename.py FILE_OR_FOLDER...

Applies the tables of CHANGELOG.md, prints each file that it changed, and each line that is left for a person. What is below `.git`,
`build` or `node_modules` stays as it is. A table's lines:

  name OLD NEW          a word of C, C++, JavaScript, C# or Kotlin, wherever it stands; {a,b} stands for each, in NEW as *
  member TYPE OLD NEW   a field of a struct, or a function of an owner, of what is declared as TYPE; @ is what it is a member of
  key OLD NEW           of a scene file
  hand WORD WHAT        nothing that a script can do"""

import pathlib
import re
import sys

CODE = {".c", ".h", ".cc", ".cpp", ".hpp", ".inl", ".mm", ".m", ".mjs", ".js", ".mts", ".ts", ".cs", ".kt", ".swift", ".md", ".txt", ".py"}


def spread(old, new):
    """Each OLD that the braces stand for, with its NEW."""
    if not (braces := re.search(r"\{(.*)\}", old)):
        return [(old, new)]
    return [(old[: braces.start()] + one + old[braces.end() :], new.replace("*", one)) for one in braces[1].split(",")]


def tables(text):
    """The rows of the tables: kind, then its words."""
    rows = []
    for block in re.findall(r"^```names\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        for line in block.splitlines():
            kind, *words = line.split(None, 2 if line.startswith("hand") else 3)
            rows += [(kind, *words)] if kind == "hand" else [(kind, *words[:-2], *pair) for pair in spread(*words[-2:])]
    return rows


def variables(text, kind):
    """What a text declares as this type, or is given by a function that returns it."""
    return set(re.findall(rf"\b{re.escape(kind)}\b(?:\s+const)?[\s&*]+(\w+)", text))


def renamed(text, suffix, rows):
    for kind, *words in rows:
        if kind == "key" and suffix == ".json":
            text = re.sub(rf'"{words[0]}"(\s*:)', rf'"{words[1]}"\1', text)
        elif kind == "name" and suffix != ".json":
            text = re.sub(rf"(?<![\w/]){re.escape(words[0])}(?!\w)", words[1], text)
        elif kind == "member" and suffix != ".json":
            for variable in variables(text, words[0]):
                new = words[2] if "@" in words[2] else "@." + words[2]
                pattern = rf"(?<![\w.>])({re.escape(variable)}(?:\[\w+\])?)(\.|->){re.escape(words[1])}(?!\w)"
                text = re.sub(pattern, lambda found, new=new: new.replace("@.", found[1] + found[2]), text)
    return text


def files(paths):
    for path in map(pathlib.Path, paths):
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if (
                file.is_file()
                and file.suffix in CODE | {".json"}
                and not {".git", "build", "node_modules"} & set(file.relative_to(path).parts)
            ):
                yield file


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    if missing := [path for path in sys.argv[1:] if not pathlib.Path(path).exists()]:
        sys.exit(f"rename.py: there is no {missing[0]}: name files and folders that exist.")
    rows = tables((pathlib.Path(__file__).resolve().parents[1] / "CHANGELOG.md").read_text())
    for file in files(sys.argv[1:]):
        try:
            text = file.read_text()
        except UnicodeDecodeError:
            continue
        by_hand = [
            (number, words)
            for number, line in enumerate(text.splitlines(), 1)
            for kind, *words in rows
            if kind == "hand" and re.search(rf"\b{re.escape(words[0])}\b", line)
        ]
        if (after := renamed(text, file.suffix, rows)) != text:
            file.write_text(after)
            print(file)
        for number, words in by_hand:
            print(f"{file}:{number}: {words[0]}: {' '.join(words[1:])}")


if __name__ == "__main__":
    main()
