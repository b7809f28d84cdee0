#!/usr/bin/env python3
"""spam.py [SECONDS [RATE [DOMAINS]]]: strangers on DDS domains (0-232; DOMAINS: e.g. 0-100) of the loopback, for tests that must
hold beside others: well-formed announcements of participants that come and go, their writers and readers of our topics' names
with foreign types and with ours, samples of nonsense by those writers, and noise; RATE datagrams a second in all (5000)."""
import os
import random
import socket
import struct
import sys
import time

TOPICS = {'request': 'Request', 'reply': 'Reply', 'edit': 'Edit', 'edit_reply': 'EditReply', 'session_state': 'SessionState',
          'pose_solution': 'PoseSolution', 'server_status': 'ServerStatus', 'hand_command': 'HandCommand', 'bridge_status': 'BridgeStatus'}
PARTICIPANT_WRITER, PUBLICATIONS_WRITER, SUBSCRIPTIONS_WRITER = 0x000100C2, 0x000003C2, 0x000004C2
READER_OF = {PARTICIPANT_WRITER: 0x000100C7, PUBLICATIONS_WRITER: 0x000003C7, SUBSCRIPTIONS_WRITER: 0x000004C7}


def parameter(number, value):
    value += b'\0' * (-len(value) % 4)
    return struct.pack('<HH', number, len(value)) + value


def text(words):
    words = words.encode() + b'\0'
    return struct.pack('<I', len(words)) + words


def locator(port):
    return struct.pack('<iI', 1, port) + b'\0' * 12 + bytes([127, 0, 0, 1])


class Stranger:
    """A participant of one domain, as it says."""

    def __init__(self, domain):
        self.domain = domain
        self.vendor = random.choice([b'\x01\x0f', b'\x01\x10', b'\x01\x01'])
        self.prefix = self.vendor + os.urandom(10)
        self.numbers = {}
        self.until = time.monotonic() + random.uniform(1, 60)
        self.port = 7400 + 250 * domain + random.choice([10, 12, 48])
        self.writers = {}

    def data(self, writer, payload, reader=0):
        number = self.numbers[writer] = self.numbers.get(writer, 0) + 1
        body = struct.pack('<HH', 0, 16) + struct.pack('>II', reader, writer) + struct.pack('<iI', 0, number) + payload
        heartbeat = struct.pack('>II', reader, writer) + struct.pack('<iIiII', 0, 1, 0, number, number)
        return (b'RTPS\x02\x03' + self.vendor + self.prefix + struct.pack('<BBH', 0x15, 0x05, len(body)) + body +
                struct.pack('<BBH', 0x07, 0x01, len(heartbeat)) + heartbeat)

    def listed(self, writer, parameters):
        return self.data(writer, b'\0\x03\0\0' + b''.join(parameters) + struct.pack('<HH', 1, 0), READER_OF[writer])

    def announcement(self):
        return self.listed(PARTICIPANT_WRITER, [
            parameter(0x0015, b'\x02\x03\0\0'), parameter(0x0016, self.vendor + b'\0\0'),
            parameter(0x0050, self.prefix + struct.pack('>I', 0x000001C1)), parameter(0x000F, struct.pack('<I', self.domain)),
            parameter(0x0032, locator(self.port)), parameter(0x0031, locator(self.port + 1)),
            parameter(0x0002, struct.pack('<iI', random.choice([10, 20, 100]), 0)), parameter(0x0058, struct.pack('<I', 0xC3F)),
            parameter(0x0062, text(random.choice(['handgraft-server', 'stranger', 'x' * 200])))])

    def endpoint(self):
        name = random.choice(list(TOPICS))
        kind = random.choice([f'handgraft::v1::{TOPICS[name]}', 'foreign::Type', f'handgraft::v1::dds_::{TOPICS[name]}_', ''])
        is_writer = random.random() < 0.5
        entity = (len(self.writers) + 1) << 8 | (0x03 if is_writer else 0x04)
        guid = self.prefix + struct.pack('>I', entity)
        if is_writer:
            self.writers[entity] = name
        return self.listed(PUBLICATIONS_WRITER if is_writer else SUBSCRIPTIONS_WRITER, [
            parameter(0x005A, guid), parameter(0x0005, text(f'handgraft/v1/{name}')), parameter(0x0007, text(kind)),
            parameter(0x001D, struct.pack('<I', random.choice([0, 1]))),  # durability
            parameter(0x001A, struct.pack('<IiI', 2, 0, 100_000_000)),  # reliable
            parameter(0x002F, locator(self.port + 1))])

    def sample(self):
        writer = random.choice(list(self.writers)) if self.writers else 0x00000103
        return self.data(writer, b'\0\x01\0\0' + os.urandom(random.choice([0, 4, 40, 400, 4000])))


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60
    rate = float(sys.argv[2]) if len(sys.argv) > 2 else 5000
    first, last = map(int, (sys.argv[3] if len(sys.argv) > 3 else '0-232').split('-'))
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    strangers = {domain: [] for domain in range(first, last + 1)}
    begin, sent = time.monotonic(), 0
    while time.monotonic() < begin + seconds:
        for domain, present in strangers.items():
            now = time.monotonic()
            present[:] = [one for one in present if one.until > now]
            if len(present) < 4:
                present.append(Stranger(domain))
            one = random.choice(present)
            what = random.random()
            if what < 0.4:
                told = one.announcement()
            elif what < 0.6:
                told = one.endpoint()
            elif what < 0.95:
                told = one.sample()
            else:
                told = os.urandom(random.randint(1, 1500))
            base = 7400 + 250 * domain
            for port in (base, base + 10, base + 11, base + 12, base + 13, base + random.randint(14, 60)):
                if port > 65535:
                    continue
                try:
                    out.sendto(told, ('127.0.0.1', port))
                except OSError:  # nobody is there
                    pass
                sent += 1
        ahead = sent / rate - (time.monotonic() - begin)
        if ahead > 0:
            time.sleep(ahead)
    print(f'{sent} datagrams in {time.monotonic() - begin:.0f} s')


main()
