#!/usr/bin/env python3
"""each_source.py BUILD tidy|alone [FOLDER ...]: every compile of BUILD/compile_commands.json, by
clang-tidy, or by its own compiler that reads and makes nothing. Goes on after a failure, prints
what was said of each, and ends with 1 if anything was. With FOLDER, of those below it alone.

What passed is not read again until it changes, or any file that it includes: build/check/passed.
"""
import concurrent.futures
import json
import os
import shlex
import subprocess
import sys
import time

import passed


def compile_of(entry):
    words = shlex.split(entry['command'])
    return words[1:] if os.path.basename(words[0]) == 'ccache' else words


def without_output(words):
    return [word for at, word in enumerate(words)
            if word not in ('-c', '-o', '-MD', '-MT', '-MF') and words[at - 1] not in ('-o', '-MT', '-MF')]


def command_of(entry, tool):
    words = compile_of(entry)
    if tool == 'tidy':
        # A source in a group is a header to clang-tidy, also where .clang-tidy asks for no headers.
        return ['clang-tidy-14', '-p', sys.argv[1], '--quiet', '--warnings-as-errors=*',
                '--header-filter=/(core|server|client|hardware|idl|tests)/',
                '--extra-arg=-Wno-unknown-warning-option', entry['file']]
    return words[:1] + ['-fsyntax-only'] + without_output(words[1:]) + ['-o', os.devnull]


def files_of(entry):
    """All that a compile reads; None if it cannot be told."""
    words = compile_of(entry)
    told = subprocess.run(words[:1] + ['-M'] + without_output(words[1:]), cwd=entry['directory'], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
    if told.returncode != 0:
        return None
    names = told.stdout.replace('\\\n', ' ').split(': ', 1)[1].split()
    return [os.path.join(entry['directory'], name) for name in names]


def main():
    build, tool = sys.argv[1:3]
    folders = tuple(os.path.abspath(folder) + os.sep for folder in sys.argv[3:])
    with open(os.path.join(build, 'compile_commands.json'), encoding='utf8') as file:
        entries = [entry for entry in json.load(file)
                   if entry['file'].endswith(('.cpp', '.cxx'))
                   and '/generated/' not in entry['file']  # not ours
                   and (tool == 'alone' or '_verify_interface_header_sets/' not in entry['file'])]
    if folders:
        entries = [entry for entry in entries if any(
            name.startswith(folders) for name in [entry['file']] + (files_of(entry) or [])
            if name.endswith('.cpp'))]
    rules = ['.clang-tidy'] if tool == 'tidy' else []
    begun, failed, known = time.monotonic(), 0, 0

    def run(entry):
        command, files = command_of(entry, tool), files_of(entry)
        key = passed.key_of(command, files + rules) if files is not None else None
        if passed.has(key):
            return None
        result = subprocess.run(command, cwd=entry['directory'] if tool == 'alone' else None, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if result.returncode == 0:
            passed.add(key)
        return result

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for done, (entry, result) in enumerate(zip(entries, pool.map(run, entries)), 1):
            known += result is None
            if result is not None and result.returncode != 0:
                failed += 1
                print(f'{entry["file"]}:\n{result.stdout}', flush=True)
            elif done % 20 == 0:
                print(f'{done} of {len(entries)}', flush=True)
    print(f'{len(entries)} compiles by {tool}, {known} known from before, {failed} failed, '
          f'{time.monotonic() - begun:.0f} s')
    return 1 if failed or not entries else 0


if __name__ == '__main__':
    sys.exit(main())
