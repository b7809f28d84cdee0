#!/usr/bin/env python3
"""each_source.py BUILD tidy|alone [FOLDER ...]: every compile of BUILD/compile_commands.json, by
clang-tidy, or by its own compiler that reads and makes nothing. Goes on after a failure, prints
what was said of each, and ends with 1 if anything was. With FOLDER, of those below it alone.
"""
import concurrent.futures
import json
import os
import shlex
import subprocess
import sys
import time


def command_of(entry, tool):
    words = shlex.split(entry['command'])
    if os.path.basename(words[0]) == 'ccache':
        words = words[1:]
    if tool == 'tidy':
        return ['clang-tidy-14', '-p', sys.argv[1], '--quiet', '--warnings-as-errors=*',
                '--extra-arg=-Wno-unknown-warning-option', entry['file']]
    return words[:1] + ['-fsyntax-only'] + [word for word in words[1:] if word != '-c'] + ['-o', os.devnull]


def main():
    build, tool = sys.argv[1:3]
    folders = tuple(os.path.abspath(folder) + os.sep for folder in sys.argv[3:])
    with open(os.path.join(build, 'compile_commands.json'), encoding='utf8') as file:
        entries = [entry for entry in json.load(file)
                   if entry['file'].endswith(('.cpp', '.cxx'))
                   and '/generated/' not in entry['file']  # not ours
                   and (tool == 'alone' or '_verify_interface_header_sets/' not in entry['file'])
                   and (not folders or entry['file'].startswith(folders))]
    begun, failed = time.monotonic(), 0

    def run(entry):
        return subprocess.run(command_of(entry, tool), cwd=entry['directory'], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for done, (entry, result) in enumerate(zip(entries, pool.map(run, entries)), 1):
            if result.returncode != 0:
                failed += 1
                print(f'{entry["file"]}:\n{result.stdout}', flush=True)
            elif done % 20 == 0:
                print(f'{done} of {len(entries)}', flush=True)
    print(f'{len(entries)} sources by {tool}, {failed} failed, {time.monotonic() - begun:.0f} s')
    return 1 if failed or not entries else 0


if __name__ == '__main__':
    sys.exit(main())
