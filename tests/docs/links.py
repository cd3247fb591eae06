#!/usr/bin/env python3
"""Every document of the tree says what is there: links, paths and headings that are named exist, and README.md stays short.

    links.py ROOT [--lines N]

Checked in every .md file:
  [text](path#heading)   the file or folder exists, and the heading in it
  `path/of/file`         exists, from the top folder, from the document's or from one above it; a file's name alone: somewhere in the tree
And README.md has at most N lines (200), its pictures at most 2 MB, and its C++ block is the file that the paragraph above it links to.

In commands and fenced blocks only paths from the top folder are looked at. Names with a placeholder (capitals alone, ..., <, *, $) are left out.
"""

import pathlib
import re
import sys

SOURCES = {".c", ".cc", ".cpp", ".cs", ".h", ".hpp", ".inl", ".java", ".md", ".mm", ".py", ".sh"}
MADE = ("build/", "out/", "Assets/", "app/")  # what commands and other programs write
LEFT_OUT = {".git", "build", "out", "control", "node_modules"}
TOP_FOLDERS = ("platform", "kernels", "runtime", "models", "tests", "toolchains")
PICTURE_BYTES = 2_000_000


def documents(root):
    for path in sorted(root.rglob("*.md")):
        if not LEFT_OUT.intersection(path.relative_to(root).parts):
            yield path


def prose(text):
    return re.sub(r"^```.*?^```", lambda block: "\n" * block.group().count("\n"), text, flags=re.MULTILINE | re.DOTALL)


def commands(text):
    """Fenced blocks, and what in backticks has more than one word."""
    return "\n".join(re.findall(r"^```.*?^```", text, re.MULTILINE | re.DOTALL) + re.findall(r"`([^`\n]* [^`\n]*)`", prose(text)))


def headings(text):
    """The anchors of a document, as GitHub makes them."""
    found = set()
    for line in re.findall(r"^#+ +(.*)$", prose(text), re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line).replace("`", "").strip().lower()
        found.add(re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"))
    return found


def check_link(document, target):
    if re.match(r"[a-z]+:", target):
        return None
    path, _, heading = target.partition("#")
    file = document if not path else document.parent / path
    if not file.exists():
        return f"no such file: {target}"
    if heading and heading not in headings(file.read_text(encoding="utf-8")):
        return f"no such heading: {target}"
    return None


def check_name(root, document, name, names):
    name = name.split("#")[0]
    if re.search(r"[\s<>*$…(){}|=,;:\"'\[\]]|\.\.\.", name) or name.startswith(("-", "/", "~", ".", "@")) or name.startswith(MADE):
        return None
    if any(re.fullmatch(r"[A-Z_]{3,}", part) for part in name.split("/")):
        return None
    if "/" not in name:
        wanted = pathlib.PurePath(name).suffix in SOURCES
        return None if not wanted or name in names else f"no such file: `{name}`"
    top = name.split("/")[0]
    folders = [document.parent, *[f for f in document.parents if root in (f, *f.parents)]]
    if not any((folder / top).exists() for folder in folders):
        return None  # a type, a ratio, an option of something else
    return None if any((folder / name).exists() for folder in folders) else f"no such path: `{name}`"


def check_readme(root, most_lines):
    readme = root / "README.md"
    text = readme.read_text(encoding="utf-8")
    lines = text.count("\n")
    if lines > most_lines:
        yield f"README.md has {lines} lines, more than {most_lines}"
    for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text):
        if (root / picture).is_file() and (root / picture).stat().st_size > PICTURE_BYTES:
            yield f"README.md: {picture} is larger than {PICTURE_BYTES} bytes"
    for paragraph, code in re.findall(r"((?:^[^\n]+\n)+)\n```cpp\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        links = re.findall(r"\]\(([^)]+\.cpp)\)", paragraph)
        if not links:
            yield "README.md: the paragraph above the code links to no file that it is of"
        elif (root / links[-1]).is_file() and (root / links[-1]).read_text(encoding="utf-8") != code:
            yield f"README.md: the code is not that of {links[-1]}"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    most_lines = int(sys.argv[3]) if sys.argv[2:3] == ["--lines"] else 200
    names = {path.name for path in root.rglob("*") if not LEFT_OUT.difference({"control"}).intersection(path.relative_to(root).parts)}
    faults, links, paths, checked = [], 0, 0, 0
    for document in documents(root):
        checked += 1
        for path in re.findall(r"(?<![\w/.-])(?:%s)/[\w./-]*\w" % "|".join(TOP_FOLDERS), commands(document.read_text(encoding="utf-8"))):
            if not (root / path).exists() and not (document.parent / path).exists():
                faults.append(f"{document.relative_to(root)}: no such path in a command: {path}")
        for number, line in enumerate(prose(document.read_text(encoding="utf-8")).split("\n"), 1):
            where = f"{document.relative_to(root)}:{number}: "
            for target in re.findall(r"\]\(([^)\s]+)\)", line):
                links += 1
                fault = check_link(document, target)
                faults += [where + fault] if fault else []
            for name in re.findall(r"`([^`]+)`", line):
                paths += 1
                fault = check_name(root, document, name, names)
                faults += [where + fault] if fault else []
    faults += check_readme(root, most_lines)
    print("\n".join(faults))
    print(f"{checked} documents, {links} links, {paths} names, {len(faults)} faults")
    return 1 if faults or links == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
