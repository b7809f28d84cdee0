#!/usr/bin/env python3
"""environment_test.py BUILD: each test of a build runs with the build's own cache of skins, and with
the sanitizers' options, which CTest drops without a word where they are passed in the wrong way.
"""
import json
import subprocess
import sys

NEEDED = ('XDG_CACHE_HOME=', 'ASAN_OPTIONS=', 'TSAN_OPTIONS=')
# They look at sources and builds, and start no program of ours.
WITHOUT = ('unit/Readmes.', 'unit/TestEnvironment.', 'unit/PageTypes')


def main():
    listed = subprocess.run(['ctest', '--test-dir', sys.argv[1], '--show-only=json-v1'],
                            stdout=subprocess.PIPE, check=True)
    tests = json.loads(listed.stdout)['tests']
    wrong = []
    for test in tests:
        if test['name'].startswith(WITHOUT):
            continue
        environment = next((p['value'] for p in test['properties'] if p['name'] == 'ENVIRONMENT'), [])
        if not all(any(entry.startswith(start) for entry in environment) for start in NEEDED):
            wrong.append(test['name'])
    for name in wrong[:20]:
        print(f'{name}: runs without the environment of tests')
    print(f'{len(tests)} tests, {len(wrong)} without their environment')
    return 1 if wrong or not tests else 0


if __name__ == '__main__':
    sys.exit(main())
