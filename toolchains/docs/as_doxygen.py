#!/usr/bin/env python3
"""What Doxygen reads instead of a public header: python3 as_doxygen.py HEADER

The headers carry plain comments. Doxygen must be told which of them are documentation. This filter tells it, and keeps every line at
its number, so that Doxygen's messages name the right line:
  a comment that begins a line     documents the declaration below it; also further functions that follow without a blank line, and all
                                   fields, where the line has several
  a comment behind a #define       documents that constant; behind other code it is no documentation
  the first comment of a file      documents the file
  the name of a function           becomes a link
  /* ---- title ---- */            heads a section of the page
  a field struct_size              is the same in every struct, and needs no comment
A comment is prose. What Doxygen would take for a command or a tag is escaped, but not in `backticks`, which show code. Lines that are
indented by four or more, behind a blank line, are shown as they stand.
"""

import pathlib
import re
import sys

# A comment, or a string, in which no comment begins.
TOKEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"', re.DOTALL)
RULER = re.compile(r"(?:/\*|//) ?-{8,}([^-*]*)")
SPECIAL = re.compile(r"[\\@<>#~]|(?<!\w)[*%](?=\w)(?!\w[\w ]*\*)")

SIZE = re.compile(r"^  uint32_t struct_size;$", re.MULTILINE)
SIZE_COMMENT = r"\g<0> /**< The size of this struct in bytes: types.h says who sets it. */"


class Prose:
    """Escapes comment lines one after the other; it knows whether it is in an indented block. Functions are named with ()."""

    functions = set()

    def __init__(self):
        self.after_blank = self.as_it_stands = False

    def line(self, text):
        start, content = re.match(r"(\s*\* ?|\s?)(.*)", text).groups()
        if not content.strip():
            self.after_blank = True
            return text
        self.as_it_stands = content.startswith("    ") and (self.after_blank or self.as_it_stands)
        self.after_blank = False
        if self.as_it_stands:
            return text
        parts = content.split("`")
        parts[::2] = [SPECIAL.sub(r"\\\g<0>", self.linked(part)) for part in parts[::2]]
        return start + "`".join(parts)

    def linked(self, part):
        return re.sub(r"\bsandglass_\w+\b(?!\()", lambda name: name.group() + "()" * (name.group() in self.functions), part)


def marked(text):
    """The text with its comments marked as documentation."""
    out, end, prose, in_section, first = [], 0, None, False, True
    for token in TOKEN.finditer(text):
        comment, between = token.group(), text[end : token.start()]
        out.append(between)
        end = token.end()
        line = text[text.rfind("\n", 0, token.start()) + 1 : token.start()]
        if line.strip() and not line.startswith("#define"):
            out.append(comment)
            continue
        if ruler := RULER.match(comment):
            title = ruler.group(1).strip()
            if title:
                out.append(("/** @} */ " if in_section else "") + f"/** @name {title} */ /** @{{ */")
            in_section = in_section or bool(title)
            continue
        if comment.startswith("//"):
            if not (prose and between.strip(" ") == "\n"):
                prose = Prose()
            out.append("///" + prose.line(comment[2:]) + (" @file" if first else ""))
        else:
            prose = Prose()
            lines = [prose.line(line) for line in comment[2:-2].split("\n")]
            lines[0] += " @file" if first else ""
            out.append(("/**<" if line.strip() else "/**") + "\n".join(lines) + "*/")
        first = False
    out.append(text[end:])
    if in_section:
        out.append("/** @} */\n")
    return SIZE.sub(SIZE_COMMENT, "".join(out))


FUNCTION = re.compile(r"(?:SANDGLASS_API|inline)\b[\w\s*:<>,]*?(\w+)\(")
FIELDS = re.compile(r"( +)([\w ]+?\**) (\w+)([][\w]*)((?:, \w+[][\w]*)+);")


def shared(text):
    """The text, in which a further function, or a further field of the same line, refers to the comment of the first."""
    out, above, struct, lines = [], None, None, text.split("\n")
    for number, line in enumerate(lines):
        if found := re.match(r"(?:typedef )?struct (\w+) {", line):
            struct = found.group(1)
        if not line.strip() or re.match(r"/\*\*|///", line):
            above = None
        elif found := FUNCTION.match("\n".join(lines[number : number + 2])):
            if above:
                line = f"/** @copydoc {above} */ {line}"
            above = above or found.group(1)
        elif struct and (found := FIELDS.match(line)):
            space, kind, first, size, others = found.groups()
            reference = f"/**< @copydoc {struct}::{first} */"
            line = f"{space}{kind} {first}{size}; " + " ".join(f"{kind} {name};{reference}" for name in others[2:].split(", "))
        out.append(line)
    return "\n".join(out)


def main():
    for header in pathlib.Path(sys.argv[1]).parent.glob("*.h"):
        Prose.functions.update(re.findall(r"\b(sandglass_\w+)\(", TOKEN.sub("", header.read_text(encoding="utf-8"))))
    with open(sys.argv[1], encoding="utf-8") as file:
        sys.stdout.write(shared(marked(file.read())))


main()
