#!/usr/bin/env python3
"""soak.py PROGRAMS DOMAIN [SECONDS [SESSIONS]]: rounds of sessions opened, edited and, once there are so many (100), the oldest
closed, models loaded and unloaded, a bridge that follows; memory, descriptors and threads of server and bridge after each tenth of the time, then what they take idle. Exit code 1 if
one of them grows from the half on by more than a tenth and 8 MB, 8 descriptors or 4 threads, or takes more than 1 % idle."""
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

TETRAHEDRON = 'v 0 0 0\nv 0.06 0 0\nv 0 0.06 0\nv 0 0 0.06\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n'


def taken(pid):
    with open(f'/proc/{pid}/status', encoding='utf8') as status:
        text = status.read()
    return (int(re.search(r'VmRSS:\s+(\d+)', text).group(1)) / 1024, len(os.listdir(f'/proc/{pid}/fd')),
            int(re.search(r'Threads:\s+(\d+)', text).group(1)))


def processor_s(pid):
    with open(f'/proc/{pid}/stat', encoding='utf8') as stat:
        fields = stat.read().rsplit(')', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def main():
    programs, domain = sys.argv[1:3]
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 1800
    most = int(sys.argv[4]) if len(sys.argv) > 4 else 100
    scratch = tempfile.TemporaryDirectory()
    with open(f'{scratch.name}/small.obj', 'w', encoding='utf8') as file:
        file.write(TETRAHEDRON)
    with open(f'{scratch.name}/edits', 'w', encoding='utf8') as file:
        file.write('weight palm 0.5\nlock thumb_distal_flex\nunlock thumb_distal_flex\nweight palm 1\nundo\n')

    failures = []

    def run(*words):
        done = subprocess.run([f'{programs}/handgraft', *words, '--domain', domain], capture_output=True, text=True, timeout=120, check=False)
        if done.returncode != 0:
            failures.append(done.stderr.strip())
            print('failed:', words[0], done.stderr.strip(), flush=True)
        return done.stdout

    environment = dict(os.environ, HANDGRAFT_STATE=f'{scratch.name}/state')
    quiet = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
    server = subprocess.Popen([f'{programs}/handgraft-server', '--domain', domain], env=environment, **quiet)
    bridge = subprocess.Popen([f'{programs}/handgraft-bridge', '--session', 'any', '--domain', domain], **quiet)
    watched = {'server': server, 'bridge': bridge}
    rows = []
    try:
        time.sleep(2)
        begin = time.monotonic()
        rounds = 0
        sessions = []
        while time.monotonic() < begin + seconds:
            told = run('grasp', '--hand', 'barrett8', '--object', 'lemon', '--contacts', 'lemon_6', '--keep')
            session = (re.search(r'session (\d+)', told) or [0, '0'])[1]
            sessions.append(session)
            run('edit', random.choice(sessions), '--script', f'{scratch.name}/edits')
            run('load', 'object', f'{scratch.name}/small.obj', '--name', f'small{rounds}')
            run('unload', 'object', f'small{rounds}')
            if len(sessions) > most:
                run('close', sessions.pop(0))
            rounds += 1
            if time.monotonic() > begin + seconds * (len(rows) + 1) / 10:
                rows.append({name: taken(one.pid) for name, one in watched.items()})
                print(f'{rounds} rounds, {len(sessions)} sessions, load {os.getloadavg()[0]:.0f}:', *(f'{name} {mb:.1f} MB {files} files {threads} threads' for name, (mb, files, threads) in rows[-1].items()), flush=True)
        time.sleep(25)  # until the last client's lease has ended
        before = {name: processor_s(one.pid) for name, one in watched.items()}
        time.sleep(30)
        idle = {name: (processor_s(one.pid) - before[name]) / 0.3 for name, one in watched.items()}
        print(f'{rounds} rounds, {len(failures)} of some {5 * rounds} commands failed; idle:', ', '.join(f'{name} {percent:.2f} %' for name, percent in idle.items()))
        failed = any(percent > 1 for percent in idle.values()) or len(failures) > rounds / 20
        for name in watched:
            half, end = rows[len(rows) // 2][name], rows[-1][name]
            failed = failed or end[0] > 1.1 * half[0] + 8 or end[1] > half[1] + 8 or end[2] > half[2] + 4
        sys.exit(failed)
    finally:
        for one in watched.values():
            one.send_signal(signal.SIGTERM)
            one.wait(30)


main()
