#!/usr/bin/env python3
"""unity_groups.py MOST FILE...: one group number a line, for the sources of one target.

Sources of a group are compiled as one, which reads shared headers once: so those that see the same
libraries come together, and what such a library makes anew in each compile is made in few. What C++
keeps apart by file, names in anonymous namespaces, would then clash: so no two sources of a group
declare the same name there. Names are read off the layout that clang-format gives (declarations of a namespace
begin in column 0); a name missed is a compile error, never a silent change.
"""
import functools
import os
import re
import sys

OPENING = re.compile(r'^namespace (\w+ )?\{')
NAME = re.compile(r'([A-Za-z_]\w*)\s*$')


def declared_name(declaration):
    """The name that a declaration, from column 0 to its first body or initialiser, declares."""
    declaration = re.sub(r'^template\s*<.*?>\s*(?=\w)', '', declaration)
    using = re.match(r'using\s+(namespace\s+)?([\w:]+)\s*(=?)', declaration)
    if using:  # the same name for the same thing is no clash
        return None if using.group(3) == '' else using.group(2)
    kind = re.match(r'(?:struct|class|union|enum(?:\s+class)?)\s+(\w+)', declaration)
    if kind:
        return kind.group(1)
    macro = re.match(r'(?:MATCHER|ACTION)\w*\((\w+)', declaration)
    if macro:
        return macro.group(1)
    depth = 0
    for at, letter in enumerate(declaration):
        if letter == '<':
            depth += 1
        elif letter == '>':
            depth -= 1
        elif depth == 0 and letter in '(={;[':
            name = NAME.search(declaration[:at])
            return name.group(1) if name else None
    return None


def hidden_names(path):
    names, uses = set(), {}
    depth_of_hidden = None
    opened = []
    lines = open(path, encoding='utf-8').read().split('\n')
    for number, line in enumerate(lines):
        space = OPENING.match(line) or re.match(r'^namespace [\w:]+ \{', line)
        if space:
            opened.append(line.startswith('namespace {'))
        elif line.startswith('}  // namespace') and opened:
            opened.pop()
        elif any(opened) and line and not line[0].isspace() and line[0] not in '})#/':
            if re.match(r'(TEST|TEST_F|TEST_P|TYPED_TEST\w*|INSTANTIATE\w*|BENCHMARK)\(', line):
                names.add(re.sub(r'\s', '', ''.join(lines[number:number + 2]).split(')')[0]))
                continue
            using = re.match(r'using (?!namespace)([\w:]+);', line)
            if using:
                uses[using.group(1).rsplit('::', 1)[-1]] = using.group(1)
                continue
            alias = re.match(r'namespace (\w+) = ([\w:]+);', line)
            if alias:
                uses[alias.group(1)] = alias.group(2)
                continue
            declaration = ' '.join(l.strip() for l in lines[number:number + 6])
            name = declared_name(declaration)
            if name and name != 'operator':
                names.add(name)
        for macro in re.findall(r'^#define (\w+)', line):
            names.add(macro)
    return names, uses


ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


@functools.lru_cache(maxsize=None)
def libraries_of(path):
    """Others' libraries that a file sees, by itself or through our headers: {'CLI', 'fmt', ...}."""
    try:
        text = open(path, encoding='utf-8').read()
    except OSError:
        return frozenset()  # generated: not there yet
    found = {name for name in re.findall(r'^#include <(\w+)/', text, re.M) if name != 'sys'}
    for header in re.findall(r'^#include "([\w/]+\.h)"', text, re.M):
        found |= libraries_of(os.path.join(ROOT, header))
    return frozenset(found)


def groups_of(files, most):
    groups = []  # (files, names, uses)
    numbers = {}
    for path in sorted(files, key=lambda path: sorted(libraries_of(path))):
        names, uses = hidden_names(path)
        for number, (count, taken, used) in enumerate(groups):
            clash = names & taken or names & used.keys() or taken & uses.keys()
            clash = clash or any(used.get(name, what) != what for name, what in uses.items())
            if count < most and not clash:
                groups[number] = (count + 1, taken | names, used | uses)
                break
        else:
            number = len(groups)
            groups.append((1, names, dict(uses)))
        numbers[path] = number
    return [numbers[path] for path in files]


if __name__ == '__main__':
    for number in groups_of(sys.argv[2:], int(sys.argv[1])):
        print(number)
