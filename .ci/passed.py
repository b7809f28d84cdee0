"""What passed before, by all that it depends on: one empty file a key in build/check/passed. So
./dev check goes on where it was stopped, and after a change repeats what the change can have broken.
"""
import functools
import hashlib
import os

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(ROOT, 'build/check/passed')


@functools.lru_cache(maxsize=None)
def hash_of(path):
    with open(path, 'rb') as file:
        return hashlib.sha256(file.read()).hexdigest()


def key_of(words, files):
    whole = hashlib.sha256('\0'.join(words).encode())
    for path in sorted(set(files)):
        path = os.path.join(ROOT, path)
        whole.update(f'{os.path.relpath(path, ROOT)} {hash_of(path)}\n'.encode())
    return whole.hexdigest()


def has(key):
    return key is not None and os.path.exists(os.path.join(FOLDER, key))


def add(key):
    if key is not None:
        os.makedirs(FOLDER, exist_ok=True)
        with open(os.path.join(FOLDER, key), 'w', encoding='utf8'):
            pass
