#!/usr/bin/env python3
"""each_test.py BUILD REGEX: the tests of a build whose names match, program by program. A program
whose tests passed is not run again until it changes, or a file that it may read; what starts other
programs not until any of those does. Ends with 1 if a test failed.

What the tests of core read is their own; all others may start the programs that are built.
"""
import json
import os
import subprocess
import sys
import time

import passed

# What judges the sources and pages themselves depends on every file.
READ_ALL = {'layering_test', 'hardware_safety_test', 'client_editor_test', 'python3'}


def ctest(build, *arguments, **keywords):
    return subprocess.run(['ctest', '--test-dir', build, *arguments], check=False, **keywords)


def tracked(*patterns):
    listed = subprocess.run(['git', 'ls-files', '--', *patterns], stdout=subprocess.PIPE, text=True, check=True)
    return [path for path in listed.stdout.split('\n')[:-1] if os.path.exists(path)]


def programs_of(build):
    """What tests start: the programs, and their stand-ins beside the tests."""
    found = [os.path.join(build, folder, name) for folder in ('bin', 'tests')
             for name in os.listdir(os.path.join(build, folder))]
    return [path for path in found if os.path.isfile(path) and not path.endswith('_test')]


def shared_data():
    """The data beside the clone, by names and sizes: without it tests are skipped."""
    folder = os.environ.get('HANDGRAFT_SHARED_DATA', os.path.join(passed.ROOT, '../shared/data'))
    return [f'{os.path.relpath(path, folder)} {os.path.getsize(path)}'
            for root, _, names in os.walk(folder) for path in (os.path.join(root, name) for name in names)]


def main():
    build, regex = sys.argv[1:3]
    listed = json.loads(ctest(build, '-R', regex, '--show-only=json-v1', stdout=subprocess.PIPE).stdout)
    everything = json.loads(ctest(build, '--show-only=json-v1', stdout=subprocess.PIPE).stdout)
    number = {test['name']: at for at, test in enumerate(everything['tests'], 1)}
    groups = {}
    for test in listed['tests']:
        labels = next((p['value'] for p in test['properties'] if p['name'] == 'LABELS'), [])
        groups.setdefault((test['command'][0], 'unit' in labels), []).append(test['name'])
    # What is no source is read as it runs: models, scenarios, golden files.
    read = tracked(':!*.cpp', ':!*.h', ':!*.md')
    started, data = programs_of(build), shared_data()
    begun, failed, known = time.monotonic(), [], 0
    for (program, is_unit), names in sorted(groups.items(), key=lambda group: not group[0][1]):
        runs = [program] if os.path.isfile(program) else []
        label = os.path.basename(program)
        files = tracked() if label in READ_ALL else read
        starts_none = is_unit and label.startswith('core_')
        key = passed.key_of(sorted(names + data), runs + files + ([] if starts_none else started))
        if passed.has(key):
            known += len(names)
            continue
        numbers = ','.join(str(number[name]) for name in names)
        if ctest(build, '-I', f'0,0,0,{numbers}', '-j', str(os.cpu_count()), '--output-on-failure').returncode:
            failed.append(label)
        else:
            passed.add(key)
    print(f'{sum(map(len, groups.values()))} tests of {build}, {known} known from before, '
          f'{time.monotonic() - begun:.0f} s' + (f', FAILED: {" ".join(failed)}' if failed else ''))
    return 1 if failed or not groups else 0


if __name__ == '__main__':
    sys.exit(main())
