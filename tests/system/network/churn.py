#!/usr/bin/env python3
"""churn.py PROGRAMS DOMAIN [SECONDS [CLIENTS]]: clients that open a session, edit it, and leave or are killed at random, each followed
by another one, on a supervised server. One client stays, and is told everything it asks; exit code 1 if it is not, or waits
for more than 10 s, or the server had to be started again."""
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time


def memory_mb(pid):
    """Of a process; 0 once it is gone."""
    try:
        with open(f'/proc/{pid}/status', encoding='utf8') as status:
            return int(re.search(r'VmRSS:\s+(\d+)', status.read()).group(1)) / 1024
    except OSError:
        return 0.0


def main():
    programs, domain = sys.argv[1:3]
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 1800
    clients = int(sys.argv[4]) if len(sys.argv) > 4 else 30
    scratch = tempfile.TemporaryDirectory()
    log = open(f'{scratch.name}/server.log', 'w+', encoding='utf8')
    environment = dict(os.environ, HANDGRAFT_STATE=f'{scratch.name}/state')
    server = subprocess.Popen([f'{programs}/handgraft-server', '--supervised', '--domain', domain], stderr=log, env=environment)

    def probe(rate, duration, **options):
        return subprocess.Popen([f'{programs}/network_probe', '--domain', domain, 'edits', '--rate', str(rate), '--seconds', str(duration)],
                                stdout=options.get('stdout', subprocess.DEVNULL), stderr=subprocess.DEVNULL)

    def said():
        with open(log.name, encoding='utf8') as text:
            return text.read()

    try:
        deadline = time.monotonic() + 60
        while 'event=ready' not in said() and time.monotonic() < deadline:
            time.sleep(0.1)

        def serving():
            return int(re.findall(r'event=supervising process=(\d+)', said())[-1])

        stays = probe(2, seconds, stdout=subprocess.PIPE)
        random.seed(1)
        others, killed, left, end = [], 0, 0, time.monotonic() + seconds
        half_mb = None
        told_until = 0
        while time.monotonic() < end:
            if len(others) < clients:
                others.append((probe(1, random.uniform(1, 20)), time.monotonic() + random.uniform(0.2, 30)))
            for one, until in list(others):
                if one.poll() is not None:
                    left += 1
                elif time.monotonic() > until:
                    one.send_signal(signal.SIGKILL)
                    one.wait()
                    killed += 1
                else:
                    continue
                others.remove((one, until))
            tenths = int(10 * (1 - (end - time.monotonic()) / seconds))
            if tenths > told_until:
                told_until = tenths
                print(f'{tenths}/10: {memory_mb(serving()):.1f} MB after {killed + left} clients; load {os.getloadavg()[0]:.0f}', flush=True)
            if half_mb is None and time.monotonic() > end - seconds / 2:
                half_mb = memory_mb(serving())
            time.sleep(0.05)
        for one, _ in others:
            one.kill()
            one.wait()
        # All that it asked must have been told by now, or soon.
        told = json.loads(stays.communicate(timeout=150)[0] or '{}')
        again = len(re.findall(r'event=supervising', said())) - 1
        now_mb = memory_mb(serving())
        for line in re.findall(r'.*event=(?:server_deaf|server_died|server_waits).*', said()):
            print(line)
        print(f'{killed} clients killed, {left} left by themselves in {seconds:.0f} s; the server started again {again} times')
        print(f'server: {half_mb:.1f} MB at the half, {now_mb:.1f} MB at the end')
        print('who stayed:', json.dumps(told))
        late = max(told[kind]['latest_ms'] for kind in ('edits', 'questions')) if told else float('inf')
        sys.exit(stays.returncode != 0 or again != 0 or late > 10_000)
    finally:
        server.send_signal(signal.SIGTERM)
        server.wait(30)


main()
