#!/usr/bin/env python3
"""readmes_test.py ROOT: a folder's README names the folder's files, all of them and no others.

Looks at each table whose first column is headed `file`: names in backticks there are files of
the folder (with or without their ending) or of folders below it; and where there is such a
table, each header of the folder is named somewhere in the README.
"""
import pathlib
import re
import sys


def tables(text):
    """The first cells of each table that is headed `file`."""
    cells, inside = [], False
    for line in text.splitlines():
        if not line.startswith('|'):
            inside = False
            continue
        first = line.split('|')[1].strip()
        if inside:
            cells.append(first)
        elif first in ('file', 'files'):
            inside = True
            cells.append('')
    return cells


def main():
    root = pathlib.Path(sys.argv[1])
    files = [path.relative_to(root) for path in root.rglob('*')
             if not {'build', '.git', 'node_modules', '__pycache__'} & set(path.relative_to(root).parts)]
    wrong = []
    for readme in files:
        if readme.name != 'README.md' or not (root / readme).exists():
            continue
        folder = readme.parent
        text = (root / readme).read_text()
        cells = tables(text)
        if not cells:
            continue
        below = [path.relative_to(folder) for path in files if folder in path.parents]
        known = {str(name) for path in below
                 for name in (path, path.parent / path.stem, path.name, path.stem, *path.parents)}
        for name in re.findall(r'`([^`]+)`', ' '.join(cells)):
            name = name.split(' ')[0].rstrip('/')
            if '*' not in name and name not in known:
                wrong.append(f'{readme}: there is no {name}')
        for path in below:
            if len(path.parts) == 1 and path.suffix == '.h' and \
                    not re.search(rf'(?<!\w){re.escape(path.stem)}(?!\w)', text):
                wrong.append(f'{readme}: does not name {path}')
    print('\n'.join(wrong) or 'each README names its folder\'s files')
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
