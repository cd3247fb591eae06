"""Reads the public headers for the generators beside this file: constants, structs, functions, and their comments.

It knows the subset of C that the headers are written in and refuses a line that it does not understand.
"""

import pathlib
import re
from typing import NamedTuple, Optional

SIZES = {
    "uint8_t": 1,
    "int8_t": 1,
    "char": 1,
    "uint16_t": 2,
    "int16_t": 2,
    "uint32_t": 4,
    "int32_t": 4,
    "int": 4,
    "float": 4,
    "uint64_t": 8,
    "int64_t": 8,
    "double": 8,
}
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)


class Refused(Exception):
    pass


class Callback(NamedTuple):
    returns: "Item"
    parameters: list


class Item(NamedTuple):
    """A field, a parameter, or what a function returns (which has no name)."""

    name: str
    base: str  # the type's name in C, without const and *; of an enumeration the header's name for it
    const: bool
    pointers: int  # a parameter that C writes as an array is a pointer, and has its count
    count: int  # of an array, else 0
    callback: Optional[Callback]
    comment: list

    @property
    def pointer(self):
        return self.pointers > 0 or self.callback is not None


class Struct(NamedTuple):
    fields: list
    comment: list


class Function(NamedTuple):
    returns: Item
    parameters: list
    comment: list


def prose(comment):
    """The sentences of a C comment as lines."""
    lines = (comment or "").strip()[2:-2].strip().split("\n")
    return [re.sub(r"^\s*\* ?", "", line).rstrip() for line in lines] if comment else []


def fails(function):
    """Whether the text of `reason`, its last argument, becomes the message of what is thrown."""
    return [item.name for item in function.parameters][-1:] == ["reason"]


def doc(comment, indent):
    """As Java and JavaScript write it."""
    lines = "".join(f"{indent} * {line}".rstrip() + "\n" for line in comment).replace("/*", "/ *").replace("*/", "* /")
    return f"{indent}/**\n{lines}{indent} */\n" if comment else ""


class Headers:
    """constants by name; enumerations: the names of their types; callbacks: function pointer types; structs and functions in an order in
    which each stands behind those that it names; handles: structs that only the library knows."""

    def __init__(self, include):
        folder = pathlib.Path(include) / "sandglass"
        first = [
            "types.h",
            "sampling.h",
            "field.h",
            "reference.h",
            "sand.h",
            "scene.h",
            "bodies.h",
            "frame.h",
        ]  # structs come before those that hold them
        self.names = sorted((path.name for path in folder.glob("*.h")), key=lambda name: ((first + [name]).index(name), name))
        texts = [(folder / name).read_text() for name in self.names]
        self.constants, self.enumerations, self.callbacks, self.structs, self.functions = {}, set(), {}, {}, {}
        for text in texts:
            self.read_constants(COMMENT.sub("", text))
        for text in texts:
            self.read_declarations(text)
        whole = "".join(texts)
        self.handles = sorted(set(re.findall(r"^typedef struct (\w+) \1;", whole, re.MULTILINE)) - set(self.structs))
        for begin, understood in ((r"^SANDGLASS_API\b", self.functions), (r"^typedef struct \w+ {", self.structs)):
            declared = len(re.findall(begin, whole, re.MULTILINE))
            if declared != len(understood):
                raise Refused(f"{declared} lines begin with {begin} and {len(understood)} were understood")
        for name, struct in self.structs.items():
            if "struct_size" in [field.name for field in struct.fields[1:]]:
                raise Refused(f"struct_size is not the first field of {name}")

    def read_constants(self, text):
        for name, value in re.findall(r"#define (SANDGLASS_(?!BRACKETS)\w+) (-?[\d.][\d.e+-]*f?|0x[0-9a-f]+)u?\n", text):
            self.constants[name] = float(value.rstrip("f")) if re.search(r"^[^x]*[.e]", value) else int(value, 0)
        for body in re.findall(r"\benum \{(.*?)\};", text, re.DOTALL):
            for name, value in re.findall(r"(SANDGLASS_\w+) = (-?\d+)", body):
                self.constants[name] = int(value)
        self.enumerations.update(re.findall(r"typedef int32_t (sandglass_\w+);", text))
        for declaration, name in re.findall(r"typedef ([^;{]* \(\*(sandglass_\w+)\)\([^;]*\));", text):
            self.callbacks[name] = self.items(declaration)[0].callback

    def read_declarations(self, text):
        comment = r"/\*(?:(?!\*/).)*\*/\s*\n"
        pattern = re.compile(
            rf"(?P<comment>{comment})?typedef struct (?P<struct>sandglass_\w+) \{{\n(?P<body>.*?)\n\}} \w+;|"
            rf"(?P<above>{comment})?SANDGLASS_API (?:SANDGLASS_NODISCARD )?(?P<returns>[\w ]+\**)\s+"
            r"(?P<function>sandglass_\w+)\((?P<parameters>[^;]*?)\);",
            re.DOTALL,
        )
        for found in pattern.finditer(text):
            if found["struct"]:
                self.structs[found["struct"]] = Struct(self.fields(found["body"]), prose(found["comment"]))
            else:
                returns = self.items(" ".join(found["returns"].split()) + " returned")[0]
                self.functions[found["function"]] = Function(returns, self.parameters(found["parameters"]), prose(found["above"]))

    def fields(self, body):
        fields, comment = [], []
        # The comment that stands behind the last field's semicolon is that of the next field.
        for part in re.finditer(r"(/\*.*?\*/)|([^;/]+);", body, re.DOTALL):
            if part[1]:
                comment = prose(part[1])
            else:
                fields += [item._replace(comment=comment) for item in self.items(part[2])]
        return fields

    def parameters(self, text):
        if text.strip() in ("", "void"):
            return []
        declared = [self.items(one)[0] for one in re.split(r",\s*(?![^()]*\))", text)]
        return [item._replace(pointers=item.pointers + (item.count > 0)) for item in declared]

    def items(self, declaration):
        declaration = " ".join(declaration.split())
        if callback := re.fullmatch(r"([\w ]+\**) \(\*(\w+)\)\((.*)\)", declaration):
            returns = self.items(callback[1] + " returned")[0]
            return [Item(callback[2], "", False, 0, 0, Callback(returns, self.parameters(callback[3])), [])]
        match = re.fullmatch(r"(const )?(?:struct )?(\w+)((?:\s|\*|const\b)*)\b(\w.*)", declaration)
        names = [re.fullmatch(r"(\w+)(?:\[(\w+)\])?", one.strip()) for one in match[4].split(",")] if match else [None]
        if None in names:
            raise Refused(declaration)
        counts = [int(name[2]) if (name[2] or "0").isdigit() and name[2] else self.constants[name[2]] if name[2] else 0 for name in names]
        return [
            Item(name[1], match[2], bool(match[1]), match[3].count("*"), count, self.callbacks.get(match[2]), [])
            for name, count in zip(names, counts)
        ]

    def size(self, item, pointer):
        """Bytes and alignment of an item, or of one of its elements, where a pointer has so many bytes."""
        if item.pointer:
            return pointer, pointer
        if item.base in self.structs:
            size, alignment, _ = self.layout(item.base, pointer)
            return size, alignment
        if item.base not in SIZES and item.base not in self.enumerations:
            raise Refused(f"unknown type {item.base} of {item.name}")
        return (SIZES.get(item.base, 4),) * 2

    def layout(self, name, pointer):
        """Bytes and alignment of a struct, and the offset of each of its fields."""
        offset, alignment, offsets = 0, 1, []
        for field in self.structs[name].fields:
            size, align = self.size(field, pointer)
            offset = (offset + align - 1) // align * align
            offsets.append(offset)
            offset += size * (field.count or 1)
            alignment = max(alignment, align)
        return (offset + alignment - 1) // alignment * alignment, alignment, offsets

    def claims(self, pointer):
        """A C file that compiles if the compiler's layouts are those above."""
        claimed = []
        for name, struct in self.structs.items():
            size, _, offsets = self.layout(name, pointer)
            claimed += [f"sizeof({name}) == {size}"]
            claimed += [f"offsetof({name}, {field.name}) == {offset}" for field, offset in zip(struct.fields, offsets)]
        return (
            "#include <stddef.h>\n"
            + "".join(f'#include "sandglass/{name}"\n' for name in self.names)
            + "".join(f"typedef char claim_{number}[({claim}) ? 1 : -1];\n" for number, claim in enumerate(claimed))
        )
