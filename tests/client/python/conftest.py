"""One server on a domain of its own for all tests of the module."""

import contextlib
import fcntl
import os
import tempfile

import pytest

import handgraft


@contextlib.contextmanager
def own_domain():
    """A DDS domain that no other test of this machine uses, as tests/support/test_domain.cpp finds one."""
    for i in range(100):
        number = 1 + (os.getpid() + i) % 100
        path = os.path.join(tempfile.gettempdir(), f"handgraft_test_domain_{number}")
        file = os.open(path, os.O_CREAT | os.O_RDWR, 0o666)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(file)
            continue
        yield number
        os.close(file)
        return
    raise RuntimeError("all DDS domains from 1 to 100 are taken by other tests")


@pytest.fixture(scope="session")
def domain():
    with own_domain() as number:
        yield number


@pytest.fixture
def empty_domain():
    with own_domain() as number:
        yield number


@pytest.fixture(scope="session")
def server(domain):
    return handgraft.connect(domain)


@pytest.fixture
def session(server):
    with server.open("barrett8", "lemon", "lemon_6") as session:
        yield session
