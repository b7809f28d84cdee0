#!/usr/bin/env bash
# discovery.sh PROGRAMS [STARTS]: how long `handgraft models` takes on a server that runs, from its start to its end:
# on the loopback, and between two hosts (network namespaces) that multicast does not reach, by peers alone.
set -euo pipefail
bin=$(realpath "$1")
starts=${2:-50}
here=$(dirname "${BASH_SOURCE[0]}")
# shellcheck source=tests/system/hosts.sh
. "$here/../system/hosts.sh"
trap tidyHosts EXIT

timed() { # WORDS COMMAND...
  python3 - "$starts" "$@" <<'END_PY'
import subprocess, sys, time
starts, words, command = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
times = []
for _ in range(starts):
    begun = time.monotonic()
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    times.append(1000 * (time.monotonic() - begun))
times.sort()
at = lambda share: times[min(len(times) - 1, round(share * (len(times) - 1)))]
print(f'{words:32} {starts} starts: p50 {at(0.5):.0f} ms, p95 {at(0.95):.0f} ms, at worst {times[-1]:.0f} ms')
END_PY
}

domain=${HANDGRAFT_DOMAIN:-97}
XDG_CACHE_HOME=$scratch "$bin/handgraft-server" --domain "$domain" --state :memory: >"$scratch/lo.log" 2>&1 &
pids+=($!)
await event=ready "$scratch/lo.log"
timed "handgraft models, loopback" "$bin/handgraft" models --domain "$domain"
timed "handgraft --version, no network" "$bin/handgraft" --version
if makeRouter >"$scratch/skip"; then
  host 1
  host 2
  start 1 server "$bin/handgraft-server" --interface auto
  await event=ready "$scratch/server.log"
  timed "handgraft models, peers alone" ip netns exec "$tag-2" "$bin/handgraft" models --interface auto --peers 10.77.1.2
else
  echo "between hosts: not measured: $(cat "$scratch/skip")"
fi
