#!/usr/bin/env python3
"""replay.py record FILE DOMAIN: keeps every datagram of a DDS domain on the loopback until it is ended (needs the right to hear a
wire: a network namespace of one's own gives it). replay.py send FILE [TIMES [PER_SECOND]]: sends them again, in their order, to where they were sent."""
import signal
import socket
import struct
import sys
import time

ETH_P_IP, OUTGOING = 0x0800, 4


def record(path, domain):
    first = 7400 + 250 * domain
    ears = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(ETH_P_IP))
    ears.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 24)
    ears.bind(('lo', 0))
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with open(path, 'wb', buffering=0) as out:
        print('hears', flush=True)
        while True:
            told, address = ears.recvfrom(1 << 16)
            header = (told[0] & 15) * 4
            if address[2] == OUTGOING or told[9] != socket.IPPROTO_UDP or struct.unpack_from('>H', told, 6)[0] & 0x3FFF:
                continue
            port, length = struct.unpack_from('>HH', told, header + 2)
            if not first <= port < first + 250:
                continue
            body = told[header + 8:header + length]
            out.write(told[16:20] + struct.pack('<HI', port, len(body)) + body)


def send(path, times, rate):
    mouth = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    mouth.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton('127.0.0.1'))
    with open(path, 'rb') as file:
        kept = file.read()
    sent = 0
    for _ in range(times):
        at = 0
        while at + 10 <= len(kept):
            port, length = struct.unpack_from('<HI', kept, at + 4)
            if at + 10 + length > len(kept):
                break
            try:
                mouth.sendto(kept[at + 10:at + 10 + length], (socket.inet_ntoa(kept[at:at + 4]), port))
                sent += 1
            except OSError:  # nobody is at that port any more
                pass
            at += 10 + length
            time.sleep(1 / rate)
    print(sent, 'datagrams', flush=True)


if sys.argv[1] == 'record':
    record(sys.argv[2], int(sys.argv[3]))
else:
    send(sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 1, float(sys.argv[4]) if len(sys.argv) > 4 else 2000)
