#!/usr/bin/env bash
# flood.sh PROGRAMS DOMAIN [MS]: three floods of 30,000 small questions a second each hold nobody's edit for more than so long.
set -euo pipefail
bin=$(realpath "$1")
domain=$2
most_ms=${3:-2000} # on a busy machine; without shares it was 3,300 to 9,600
# shellcheck source=tests/system/programs.sh
. "$(dirname "${BASH_SOURCE[0]}")/../programs.sh"
start server "$bin/handgraft-server" --domain "$domain"
await event=ready "$scratch/server.log"
for i in 1 2 3; do start "flood$i" "$bin/network_probe" --domain "$domain" flood --rate 30000 --seconds 9; done
sleep 1
told=$("$bin/network_probe" --domain "$domain" edits --rate 10 --seconds 4 2>/dev/null) || fail "something was never answered: $told"
echo "$told"
cat "$scratch"/flood*.log
python3 -c 'import json, sys; sys.exit(json.loads(sys.argv[1])["edits"]["latest_ms"] > float(sys.argv[2]))' "$told" "$most_ms" ||
  fail "an edit was held for more than $most_ms ms"
