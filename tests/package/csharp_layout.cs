// Writes a claim in C for every struct's size, every field's offset and size, and every constant of Sandglass.cs. The
// target's C compiler compiles them against the headers.
using System;
using System.Reflection;
using System.Runtime.InteropServices;
using Sandglass;

static class Layout {
  static int claims;

  static void Claim(string condition, string what) {
    Console.WriteLine("typedef char claim_{0}[({1}) ? 1 : -1]; /* {2} */", claims++, condition, what);
  }

  static void Main() {
    foreach (Type type in typeof(Native).Assembly.GetTypes()) {
      FieldInfo[] fields = type.GetFields(BindingFlags.Instance | BindingFlags.Public);
      if (!type.IsValueType || !type.Name.StartsWith("sandglass_") || fields.Length == 0) continue;
      Claim("sizeof(" + type.Name + ") == " + Marshal.SizeOf(type), "size of " + type.Name);
      foreach (FieldInfo field in fields) {
        object[] renamed = field.GetCustomAttributes(typeof(CNameAttribute), false);
        string name = renamed.Length == 0 ? field.Name : ((CNameAttribute)renamed[0]).Name;
        Claim("offsetof(" + type.Name + ", " + name + ") == " + Marshal.OffsetOf(type, field.Name), type.Name + "." + name);
        Claim("sizeof(((" + type.Name + "*)0)->" + name + ") == " + Size(field.FieldType), "size of " + type.Name + "." + name);
      }
    }
    foreach (FieldInfo field in typeof(Native).GetFields(BindingFlags.Static | BindingFlags.Public)) {
      if (!field.IsLiteral) continue;
      string cast = field.FieldType == typeof(float) ? "(int)" : "";  // C claims whole numbers
      Claim(cast + field.Name + " == " + field.GetRawConstantValue(), field.Name);
    }
  }

  // Marshal cannot size a pointer type. A fixed buffer is a struct that the compiler made.
  static int Size(Type type) { return type.IsPointer ? IntPtr.Size : Marshal.SizeOf(type); }
}
