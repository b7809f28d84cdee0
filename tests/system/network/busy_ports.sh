#!/usr/bin/env bash
# busy_ports.sh PROGRAMS DOMAIN: where all ports of a domain's participants are taken, a server says so and ends, in place of
# saying that it is ready and hearing nobody; once there are some, it serves.
set -euo pipefail
bin=$(realpath "$1")
domain=$2
# shellcheck source=tests/system/programs.sh
. "$(dirname "${BASH_SOURCE[0]}")/../programs.sh"
cat >"$scratch/take.py" <<'END_PY'
import socket, sys, time
taken = []
for port in range(7410 + 250 * int(sys.argv[1]), 7400 + 250 * (int(sys.argv[1]) + 1)):
    taken.append(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    taken[-1].bind(('0.0.0.0', port))
print('taken', flush=True)
time.sleep(600)
END_PY
start taker python3 "$scratch/take.py" "$domain"
taker=${pids[-1]}
await taken "$scratch/taker.log"
code=0
timeout 60 "$bin/handgraft-server" --domain "$domain" >"$scratch/server.log" 2>&1 || code=$?
cat "$scratch/server.log"
[ "$code" = 1 ] || fail "the server ended with $code"
grep -q event=ready "$scratch/server.log" && fail "it says that it is ready"
grep -q "ports .* are taken" "$scratch/server.log" || fail "it does not say why"
kill "$taker"
wait "$taker" || true
start served "$bin/handgraft-server" --domain "$domain"
await event=ready "$scratch/served.log"
"$bin/handgraft" models --domain "$domain" >"$scratch/models" 2>&1 || { cat "$scratch/models"; fail "no answer"; }
echo "busy_ports: passed"
