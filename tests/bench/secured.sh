#!/usr/bin/env bash
# secured.sh PROGRAMS [STARTS]: a secured domain beside an open one: the round trip of a small request, and whether
# server and client, started in either order, always meet.
set -euo pipefail
bin=$(realpath "$1")
starts=${2:-200}
# shellcheck source=tests/system/programs.sh
. "$(dirname "${BASH_SOURCE[0]}")/../system/programs.sh"
export XDG_CACHE_HOME=$scratch HANDGRAFT_DOMAIN=${HANDGRAFT_DOMAIN:-96}
unset HANDGRAFT_IDENTITY
keys=$scratch/keys
"$bin/handgraft" keys init "$keys" >/dev/null
for role in server editor hand; do "$bin/handgraft" keys add "$role" --role "$role" --dir "$keys" >/dev/null; done
start open "$bin/handgraft-server" --domain $((HANDGRAFT_DOMAIN - 1))
start secured "$bin/handgraft-server" --identity "$keys/server"
for name in open secured; do await event=ready "$scratch/$name.log"; done
python3 - "$bin" "$keys" "$starts" "$HANDGRAFT_DOMAIN" <<'END_PY'
import json, statistics, subprocess, sys
program, keys, domain = sys.argv[1], sys.argv[2], int(sys.argv[4])
def doctor(*options):
    run = subprocess.run([program + '/handgraft', 'doctor', '--json', *options], capture_output=True, check=True)
    told = json.loads(run.stdout)
    return told['round_trip_ms'], told['found_ms']
open_, secured = [], []
for _ in range(40):  # in turn, so that both see the same machine
    open_.append(doctor('--domain', str(domain - 1)))
    secured.append(doctor('--identity', keys + '/editor'))
median = lambda rows, column: statistics.median(row[column] for row in rows)
print(f'round trip, 40 programs of 11: open {median(open_, 0):.3f} ms, secured {median(secured, 0):.3f} ms, '
      f'ratio {median(secured, 0) / median(open_, 0):.2f}')
print(f'server found: open {median(open_, 1):.0f} ms, secured {median(secured, 1):.0f} ms')
END_PY
tidy
mkdir -p "$scratch" && "$bin/handgraft" keys init "$keys" >/dev/null
for role in server editor hand; do "$bin/handgraft" keys add "$role" --role "$role" --dir "$keys" >/dev/null; done
python3 - "$bin" "$keys" "$starts" <<'END_PY'
import random, select, signal, subprocess, sys, time
program, keys, starts = sys.argv[1], sys.argv[2], int(sys.argv[3])
server = [program + '/handgraft-server', '--identity', keys + '/server', '--state', ':memory:']
client = [program + '/handgraft-bridge', '--identity', keys + '/hand', '--disarmed']
def until(words, process, deadline):
    said = b''
    while words not in said and time.monotonic() < deadline:
        if select.select([process.stderr], [], [], 0.05)[0]: said += process.stderr.read1(65536)
    return time.monotonic() if words in said else None
times, failed = {'server first': [], 'client first': []}, []
for i in range(starts):
    order = ('server first', 'client first')[i % 2]
    first, second = (server, client) if i % 2 == 0 else (client, server)
    one = subprocess.Popen(first, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    time.sleep(random.uniform(0, 1))
    other = subprocess.Popen(second, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    serving, joining = (one, other) if i % 2 == 0 else (other, one)
    deadline = time.monotonic() + 30
    ready = until(b'event=ready', serving, deadline)
    found = until(b'server found', joining, deadline)
    if ready and found: times[order].append(1000 * max(0.0, found - ready))
    else: failed.append((order, 'no server' if not ready else 'not found within 30 s'))
    for each in (joining, serving):
        each.send_signal(signal.SIGTERM)
        each.communicate()
for order, each in times.items():
    each.sort()
    if each: print(f'{order}: {len(each)} joined, p50 {each[len(each) // 2]:.0f} ms, at worst {each[-1]:.0f} ms after "ready"')
print(f'{starts - len(failed)} of {starts} starts joined')
for order, error in failed[:5]: print(f'  {order}: {error}')
sys.exit(bool(failed))
END_PY
