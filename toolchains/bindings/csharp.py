#!/usr/bin/env python3
"""The C API in C#, for Unity and any other .NET: python3 csharp.py INCLUDE_FOLDER Sandglass.cs

One to one, by one rule. A pointer in C is a pointer here, and NULL is null; a handle is a pointer to an empty struct. An enumeration is an
int. A callback is a delegate as an argument of a function, else an IntPtr. An array of structs or pointers becomes fields: the address of
the first, name_0, is that of the array.
"""

import html
import pathlib
import sys

from headers import Headers, Refused

TYPES = {
    "uint8_t": "byte",
    "int8_t": "sbyte",
    "char": "byte",
    "uint16_t": "ushort",
    "int16_t": "short",
    "uint32_t": "uint",
    "int32_t": "int",
    "int": "int",
    "uint64_t": "ulong",
    "int64_t": "long",
    "float": "float",
    "double": "double",
    "void": "void",
}
KEYWORDS = {"in", "out", "ref", "params", "object", "string", "base", "lock", "fixed", "event", "operator", "checked", "is", "as"}

HEAD = """\
// Generated from Sandglass's public headers by csharp.py: the C API, one to one. Nothing here allocates; what calls it every frame should
// keep its structs and arrays.
//
// Keep a reference to each delegate for as long as the library has its function pointer (Marshal.GetFunctionPointerForDelegate); under
// IL2CPP make it a static method with [MonoPInvokeCallback].
using System;
using System.Runtime.InteropServices;

namespace Sandglass {

// What a field is called in C where C# cannot spell it.
[AttributeUsage(AttributeTargets.Field)]
public sealed class CNameAttribute : Attribute {
  public readonly string Name;
  public CNameAttribute(string name) { Name = name; }
}

"""
NATIVE = """\
public static unsafe class Native {
#if UNITY_IOS && !UNITY_EDITOR
  const string k_library = "__Internal";  // linked into the app
#else
  const string k_library = "sandglass";  // libsandglass.so, libsandglass.dylib
#endif

  public const int SANDGLASS_VERSION =
      1000000 * SANDGLASS_VERSION_MAJOR + 1000 * SANDGLASS_VERSION_MINOR + SANDGLASS_VERSION_PATCH;
  /// <summary>Whether the native library is of the version that these structs mirror: ask before any other call.</summary>
  public static bool VersionFits() { return sandglass_version() / 1000 == SANDGLASS_VERSION / 1000; }
  /// <summary>The sentence behind a `reason` or a name; null for NULL.</summary>
  public static string Text(byte* sentence) { return sentence == null ? null : Marshal.PtrToStringAnsi((IntPtr)sentence); }

"""


def spelled(headers, item):
    """The type of a field, or of an element of it, or of a parameter."""
    if item.callback:
        return item.base if item.base in headers.callbacks else "IntPtr"
    if item.base in headers.structs or item.base in headers.handles:
        return item.base + "*" * item.pointers
    return ("int" if item.base in headers.enumerations else TYPES[item.base]) + "*" * item.pointers


def name_of(item):
    return "@" * (item.name in KEYWORDS) + item.name


def doc(comment, indent):
    lines = [f"{indent}/// {html.escape(line, quote=False)}".rstrip() + "\n" for line in comment]
    return f"{indent}/// <summary>\n{''.join(lines)}{indent}/// </summary>\n" if lines else ""


def parameters(headers, items):
    return ", ".join(f"{spelled(headers, item)} {name_of(item)}" for item in items)


def delegate(headers, name, callback):
    given = [item._replace(base="") if item.callback else item for item in callback.parameters]
    return (
        "[UnmanagedFunctionPointer(CallingConvention.Cdecl)]\n"
        f"public unsafe delegate {spelled(headers, callback.returns)} {name}({parameters(headers, given)});\n\n"
    )


def field(headers, item):
    kind = "IntPtr" if item.callback else spelled(headers, item)
    if not item.count:
        return f"  public {kind} {name_of(item)};\n"
    if not item.pointer and item.base not in headers.structs:
        return f"  public fixed {kind} {name_of(item)}[{item.count}];\n"
    return "".join(f'  [CName("{item.name}[{i}]")] public {kind} {item.name}_{i};\n' for i in range(item.count))


def csharp(headers):
    out = [HEAD]
    out += [f"public struct {name} {{}}\n\n" for name in headers.handles]
    out += [delegate(headers, name, callback) for name, callback in headers.callbacks.items()]
    for name, struct in headers.structs.items():
        out.append(f"{doc(struct.comment, '')}[StructLayout(LayoutKind.Sequential)]\npublic unsafe struct {name} {{\n")
        out += [doc(item.comment, "  ") + field(headers, item) for item in struct.fields] + ["}\n\n"]
    out.append(NATIVE)
    for name, value in headers.constants.items():
        kind, end = ("float", "f") if isinstance(value, float) else ("uint", "") if value > 0x7FFFFFFF else ("int", "")
        out.append(f"  public const {kind} {name} = {value}{end};\n")
    for name, function in headers.functions.items():
        out.append(
            f"\n{doc(function.comment, '  ')}  [DllImport(k_library)]\n"
            f"  public static extern {spelled(headers, function.returns)} {name}({parameters(headers, function.parameters)});\n"
        )
    return "".join(out) + "}\n\n}  // namespace Sandglass\n"


if __name__ == "__main__":
    try:
        pathlib.Path(sys.argv[2]).write_text(csharp(Headers(sys.argv[1])))
    except Refused as refused:
        sys.exit(f"csharp.py does not understand a header: {refused}")
