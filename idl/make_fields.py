#!/usr/bin/env python3
"""make_fields.py OUT_DIR FILE.idl...: what the messages of the contract consist of, as tables.

Writes OUT_DIR/contract.h, a table's name a type, and OUT_DIR/contract.cpp, the tables (idl/fields.h
says what is in them). Files come in the order of their dependencies. What is read of IDL is what
idl/README.md allows: structs, unions, enums, sequences, arrays, strings, numbers, constants, @range;
in the comment behind a member, @infinite and @nan say that it may be that.
"""
import re
import sys
from pathlib import Path

BASIC = {
    "boolean": "bool", "octet": "std::uint8_t", "long": "std::int32_t",
    "unsigned long": "std::uint32_t", "long long": "std::int64_t",
    "unsigned long long": "std::uint64_t", "float": "float", "double": "double",
    "string": "std::string",
}
KINDS = {
    "boolean": "kBoolean", "octet": "kOctet", "long": "kInt32", "unsigned long": "kUint32",
    "long long": "kInt64", "unsigned long long": "kUint64", "float": "kFloat",
    "double": "kDouble", "string": "kString",
}
TOKEN = re.compile(r"//[^\n]*|#[^\n]*|@?\w+(?:\.\w+)?(?:[eE][+-]?\d+)?|::|[{}()<>\[\];:,=]|-")


class Reader:
    def __init__(self, path):
        self.path = path
        self.tokens = []
        self.marks = {}  # of the token before a comment, the comments behind it
        for token in TOKEN.findall(path.read_text()):
            if token.startswith("#"):
                continue
            if token.startswith("//"):
                at = len(self.tokens) - 1
                self.marks[at] = self.marks.get(at, "") + token
            else:
                self.tokens.append(token)
        self.at = 0

    def peek(self):
        return self.tokens[self.at] if self.at < len(self.tokens) else None

    def next(self, expected=None):
        token = self.peek()
        if token is None or expected not in (None, token):
            sys.exit(f"{self.path}: '{token}' where '{expected}' was expected")
        self.at += 1
        return token

    def mark(self):
        return self.marks.get(self.at - 1, "")


class Contract:
    def __init__(self):
        self.order = []      # names of structs, unions and enums, dependencies first
        self.enums = {}      # name -> enumerators
        self.structs = {}    # name -> members
        self.unions = {}     # name -> (discriminator, members)
        self.aliases = {}    # typedef name -> type
        self.constants = {}

    def read(self, path):
        source = Reader(path)
        while source.peek():
            token = source.next()
            if token == "module":
                source.next()
                source.next("{")
            elif token == "@final" or token in ("}", ";"):
                continue
            elif token == "const":
                self.type(source)
                name = source.next()
                source.next("=")
                self.constants[name] = source.next()
                source.next(";")
            elif token == "typedef":
                kind = self.type(source)
                name = source.next()
                self.aliases[name] = self.array(source, kind)
                source.next(";")
            elif token == "enum":
                self.enum(source)
            elif token == "struct":
                name = source.next()
                source.next("{")
                members = []
                while source.peek() != "}":
                    members.append(self.member(source, []))
                source.next("}")
                self.structs[name] = members
                self.order.append(name)
            elif token == "union":
                self.union(source)
            else:
                sys.exit(f"{path}: '{token}' is not understood")

    def enum(self, source):
        name = source.next()
        source.next("{")
        enumerators = []
        while source.peek() != "}":
            enumerators.append(source.next())
            if source.peek() == ",":
                source.next()
        source.next("}")
        self.enums[name] = enumerators
        self.order.append(name)

    def union(self, source):
        name = source.next()
        source.next("switch")
        source.next("(")
        discriminator = source.next()
        source.next(")")
        source.next("{")
        members = []
        labels = []
        while source.peek() != "}":
            if source.peek() == "case":
                source.next()
                labels.append(source.next())
                source.next(":")
            else:
                members.append(self.member(source, labels))
                labels = []
        source.next("}")
        self.unions[name] = (discriminator, members)
        self.order.append(name)

    def type(self, source):
        token = source.next()
        if token == "sequence":
            source.next("<")
            element = self.type(source)
            bound = "0"
            if source.peek() == ",":
                source.next()
                bound = source.next()
            source.next(">")
            return ("sequence", element, int(self.constants.get(bound, bound)))
        if token == "unsigned":
            token += " " + source.next()
        if token.endswith("long") and source.peek() == "long":
            token += " " + source.next()
        return self.aliases.get(token, token)

    def array(self, source, kind):
        if source.peek() != "[":
            return kind
        source.next("[")
        count = int(source.next())
        source.next("]")
        return ("array", kind, count)

    def member(self, source, labels):
        bounds = {}
        while source.peek().startswith("@"):
            annotation = source.next()
            if annotation == "@range":
                source.next("(")
                while source.peek() != ")":
                    key = source.next()
                    source.next("=")
                    sign = source.next() if source.peek() == "-" else ""
                    bounds[key] = sign + source.next()
                    if source.peek() == ",":
                        source.next()
                source.next(")")
        kind = self.type(source)
        name = source.next()
        kind = self.array(source, kind)
        source.next(";")
        mark = source.mark()
        return {"name": name, "type": kind, "labels": labels,
                "least": bounds.get("min"), "most": bounds.get("max"),
                "infinite": "@infinite" in mark, "nan": "@nan" in mark}


class Writer:
    def __init__(self, contract):
        self.contract = contract
        self.lines = []
        self.composed = {}  # C++ type -> name of its table

    def cpp(self, kind):
        if isinstance(kind, tuple):
            element = self.cpp(kind[1])
            return f"std::array<{element}, {kind[2]}>" if kind[0] == "array" else f"std::vector<{element}>"
        return BASIC.get(kind, kind)

    def table(self, kind):
        """The name of the table of a type, which is written first if it is a new one."""
        if not isinstance(kind, tuple):
            return f"idl::{KINDS[kind]}Type" if kind in BASIC else f"k{kind}Type"
        if kind not in self.composed:
            element = self.table(kind[1])
            name = f"kType{len(self.composed)}"
            make = "arrayOf" if kind[0] == "array" else "sequenceOf"
            self.lines.append(f"constexpr Type {name} = idl::{make}<{self.cpp(kind)}>({element}, {kind[2]});")
            self.composed[kind] = name
        return self.composed[kind]

    def fields(self, owner, members):
        rows = []
        for one in members:
            table = self.table(one["type"])
            number = f"{owner}, {one['name']}"
            least = one["least"] or "-idl::kInfinity"
            most = one["most"] or "idl::kInfinity"
            labels = "{}"
            if one["labels"]:
                labels = f"k{owner}_{one['name']}"
                listed = ", ".join(one["labels"])
                self.lines.append(f"constexpr std::uint32_t {labels}[] = {{{listed}}};")
            flags = f"{str(one['infinite']).lower()}, {str(one['nan']).lower()}"
            rows.append(f'    {{"{one["name"]}", &{table}, HANDGRAFT_MEMBER({number}), {least}, {most}, '
                        f"{flags}, {labels}}},")
        if rows:
            self.lines.append(f"constexpr Field k{owner}Fields[] = {{")
            self.lines += rows
            self.lines.append("};")
            return f"k{owner}Fields"
        return "{}"

    def define(self, owner, entries):
        self.lines.append(f"constinit const Type k{owner}Type = {{{entries}}};")
        self.lines.append("")

    def write(self):
        for name in self.contract.order:
            if name in self.contract.enums:
                all_names = self.contract.enums[name]
                prefix = common(all_names)
                self.lines.append(f"constexpr Enumerator k{name}Names[] = {{")
                for one in all_names:
                    self.lines.append(f'    {{"{one[len(prefix):].lower()}", {one}}},')
                self.lines.append("};")
                self.define(name, f'.kind = idl::Kind::kEnum, .name = "{name}", .names = k{name}Names')
            elif name in self.contract.structs:
                fields = self.fields(name, self.contract.structs[name])
                self.define(name, f'.kind = idl::Kind::kStruct, .name = "{name}", .fields = {fields}')
            else:
                self.union(name)
        return "\n".join(self.lines)

    def union(self, name):
        discriminator, members = self.contract.unions[name]
        fields = self.fields(name, members)
        self.lines.append(f"static void choose{name}(void* message, std::uint32_t label) {{")
        self.lines.append(f"  auto& body = *static_cast<{name}*>(message);")
        self.lines.append("  switch (label) {")
        for one in members:
            for label in one["labels"]:
                self.lines.append(f"    case {label}:")
            self.lines.append(f"      body.{one['name']}({self.cpp(one['type'])}());")
            self.lines.append("      break;")
        self.lines.append("  }")
        self.lines.append(f"  body._d(static_cast<{discriminator}>(label));")
        self.lines.append("}")
        self.lines.append(f"static std::uint32_t label{name}(const void* message) {{")
        self.lines.append(f"  return static_cast<const {name}*>(message)->_d();")
        self.lines.append("}")
        self.define(name, f'.kind = idl::Kind::kUnion, .name = "{name}", .fields = {fields}, '
                    f".discriminator = &k{discriminator}Type, .label = label{name}, "
                    f".choose = choose{name}")


def common(names):
    """What all enumerators begin with, to its last underscore."""
    prefix = names[0]
    for name in names:
        while not name.startswith(prefix):
            prefix = prefix[:-1]
    return prefix[:prefix.rfind("_") + 1]


def main():
    out = Path(sys.argv[1])
    files = [Path(name) for name in sys.argv[2:]]
    contract = Contract()
    for path in files:
        contract.read(path)

    header = ['// Made by idl/make_fields.py.', '#pragma once', '', '#include <cstdint>', '',
              'namespace handgraft::idl {', 'struct Type;', '}', '', 'namespace handgraft::v1 {']
    for name in contract.order:
        enum = name in contract.enums
        header.append(f"enum {name} : std::uint32_t;" if enum else f"class {name};")
        header.append(f"extern const idl::Type k{name}Type;")
        header.append(f"inline const idl::Type& typeFor(const {name}*) {{ return k{name}Type; }}")
    header += ["}", "", "#define HANDGRAFT_EACH_MESSAGE(Do) \\"]
    header += [f"  Do({name}) \\" for name in contract.order if name not in contract.enums]
    header.append("")
    source = ['// Made by idl/make_fields.py.', '#include <array>', '#include <string>',
              '#include <vector>', '', '#include "idl/fields.h"']
    source += [f'#include "idl/{path.stem}.h"' for path in files]
    source += ['', 'namespace handgraft::v1 {', '', 'using idl::Enumerator, idl::Field, idl::Type;', '',
               '#define HANDGRAFT_MEMBER(Owner, member)                        \\',
               '  [](void* message) -> void* {                                 \\',
               '    return &static_cast<Owner*>(message)->member();        \\',
               '  }', '']
    body = Writer(contract).write()
    source.append(body)
    out.mkdir(parents=True, exist_ok=True)
    (out / "contract.h").write_text("\n".join(header) + "\n")
    (out / "contract.cpp").write_text("\n".join(source) + "\n}\n")


main()
