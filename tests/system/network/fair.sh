#!/usr/bin/env bash
# fair.sh PROGRAMS DOMAIN [TIMES]: what a calm session's edits wait for (10 a second), alone and beside clients that send as many
# edits as they can; fails where its p95 beside them is more than so many TIMES (3) that of alone, 5 ms at least. By hand:
# it measures.
set -euo pipefail
bin=$(realpath "$1")
domain=$2
times=${3:-3}
# shellcheck source=tests/system/programs.sh
. "$(dirname "${BASH_SOURCE[0]}")/../programs.sh"
start server "$bin/handgraft-server" --domain "$domain"
await event=ready "$scratch/server.log"
calm() { "$bin/network_probe" --domain "$domain" edits --rate 10 --seconds 20 2>/dev/null; }
calm >/dev/null # what is made once is made now
alone=$(calm)
echo "alone: $alone"
for i in 1 2 3 4 5; do start "noisy$i" "$bin/network_probe" --domain "$domain" edits --rate 10000 --seconds 30; done
sleep 4
beside=$(calm)
echo "beside five: $beside"
echo "load $(cut -d' ' -f1 /proc/loadavg)"
python3 - "$alone" "$beside" "$times" <<'END_PY' || fail "the calm session waits too long"
import json, sys
alone, beside = (json.loads(one)['edits']['p95_ms'] for one in sys.argv[1:3])
print(f'p95 {alone} ms alone, {beside} ms beside: {beside / alone:.1f} times')
sys.exit(beside > float(sys.argv[3]) * max(alone, 5.0))
END_PY
