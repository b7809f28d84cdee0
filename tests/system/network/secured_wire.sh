#!/usr/bin/env bash
# secured_wire.sh PROGRAMS: a secured domain between two hosts, where datagrams are frames of 1,400 bytes at most: handshakes, which carry
# certificates and permissions, come whole through the filters of both sides. Exits with 77 where namespaces cannot be made.
set -euo pipefail
bin=$(realpath "$1")
# shellcheck source=tests/system/network/wire.sh
. "$(dirname "${BASH_SOURCE[0]}")/wire.sh"
fail() { echo "secured_wire: $*" >&2; exit 1; }
makeWire >"$scratch/skip" || { echo "secured_wire: skipped: $(cat "$scratch/skip")"; exit 77; }

keys=$scratch/keys
"$bin/handgraft" keys init "$keys" >/dev/null
for role in server editor viewer hand; do "$bin/handgraft" keys add "a-$role" --role "$role" --dir "$keys" >/dev/null; done
start b hand "$bin/handgraft-bridge" --interface auto --identity "$keys/a-hand" --disarmed # before the server
start a server "$bin/handgraft-server" --interface auto --identity "$keys/a-server"
await event=ready "$scratch/server.log"
begun=$(date +%s%N)
on b timeout 60 "$bin/network_probe" --interface auto --identity "$keys/a-editor" edits --rate 5 --seconds 1 >"$scratch/told" 2>"$scratch/why" ||
  { cat "$scratch/why"; fail "the editor was not answered"; }
echo "$(($(date +%s%N) / 1000000 - begun / 1000000)) ms until all was told, of which 1,000 are edits: $(cat "$scratch/told")"
for who in editor viewer; do
  for _ in 1 2 3 4 5; do # a command waits for 2 s
    HANDGRAFT_IDENTITY=$keys/a-$who on b timeout 60 "$bin/handgraft" models --interface auto >"$scratch/models" 2>&1 && break
  done
  grep -q barrett8 "$scratch/models" || { cat "$scratch/models"; fail "a-$who was not answered"; }
done
await 'server' "$scratch/hand.log"
