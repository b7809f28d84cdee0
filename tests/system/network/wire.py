#!/usr/bin/env python3
"""wire.py HOST_A HOST_B FIFO: a bad wire between two network namespaces, in place of `tc netem`, which not every kernel has.

Each gets `eth0`, 10.78.0.1 and .2. FIFO takes lines `loss PERCENT`, `delay MS`, `cut 0|1`, `count`, `end`; each is answered on
standard output by one of JSON with the bytes and frames that A and B have sent since the last `count`. Loss is of
Ethernet frames, so of each fragment by itself.
"""
import fcntl
import heapq
import json
import os
import random
import select
import struct
import subprocess
import sys
import time

TUNSETIFF, TAP_WITHOUT_HEADER = 0x400454CA, 0x1002


def plug(name, host, address):
    tap = os.open('/dev/net/tun', os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tap, TUNSETIFF, struct.pack('16sH', name.encode(), TAP_WITHOUT_HEADER))
    for command in (f'ip link set {name} netns {host}', f'ip -n {host} link set {name} name eth0 txqueuelen 10000',
                    f'ip -n {host} addr add {address}/24 dev eth0', f'ip -n {host} link set eth0 up',
                    f'ip -n {host} link set lo up', f'ip -n {host} route add 224.0.0.0/4 dev eth0'):
        subprocess.check_call(command.split())
    return tap


def main():
    host_a, host_b, fifo = sys.argv[1:]
    ends = [plug(f'hga{os.getpid()}', host_a, '10.78.0.1'), plug(f'hgb{os.getpid()}', host_b, '10.78.0.2')]
    orders = os.open(fifo, os.O_RDWR | os.O_NONBLOCK)
    loss, delay, cut = 0.0, 0.0, False
    sent = {'a_bytes': 0, 'b_bytes': 0, 'a_frames': 0, 'b_frames': 0}
    on_the_way, number, text = [], 0, b''
    print('wired', flush=True)
    while True:
        now = time.monotonic()
        while on_the_way and on_the_way[0][0] <= now:
            _, _, to, frame = heapq.heappop(on_the_way)
            try:
                os.write(to, frame)
            except OSError:  # its queue is full, or it is down: lost
                pass
        wait = max(0.0, on_the_way[0][0] - now) if on_the_way else 1.0
        for ready in select.select([*ends, orders], [], [], wait)[0]:
            if ready == orders:
                text += os.read(orders, 4096)
                *lines, text = text.split(b'\n')
                for line in lines:
                    word, *value = line.decode().split()
                    if word == 'end':
                        return
                    if word == 'loss':
                        loss = float(value[0]) / 100
                    if word == 'delay':
                        delay = float(value[0]) / 1000
                    if word == 'cut':
                        cut = value[0] == '1'
                    print(json.dumps(sent), flush=True)
                    if word == 'count':
                        sent = dict.fromkeys(sent, 0)
                continue
            try:
                for _ in range(64):
                    frame = os.read(ready, 65536)
                    who = 'a' if ready == ends[0] else 'b'
                    sent[who + '_bytes'] += len(frame)
                    sent[who + '_frames'] += 1
                    if cut or random.random() < loss:
                        continue
                    to = ends[1] if ready == ends[0] else ends[0]
                    if delay == 0.0:
                        os.write(to, frame)
                    else:
                        number += 1
                        heapq.heappush(on_the_way, (time.monotonic() + delay, number, to, frame))
            except OSError:  # nothing more, or the other end's queue is full
                pass


main()
