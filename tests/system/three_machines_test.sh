#!/usr/bin/env bash
# three_machines_test.sh PROGRAMS PAGE: does what docker/THREE_MACHINES.md says, word by word, on three hosts (network
# namespaces) that multicast does not reach. Exits with 77 where namespaces cannot be made.
set -euo pipefail
bin=$(realpath "$1")
page=$(realpath "$2")
cd "$(dirname "$page")/.."
# shellcheck source=tests/system/hosts.sh
. "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"
trap tidyHosts EXIT
fail() { echo "three_machines_test: $*" >&2; exit 1; }
makeRouter >"$scratch/skip" || { echo "three_machines_test: skipped: $(cat "$scratch/skip")"; exit 77; }
export PATH=$bin:$PATH
for n in 1 2 3; do host "$n"; done

# The page's blocks, and whose they are.
awk -v out="$scratch/block" '/^```sh/ { n++; next } /^```/ { on = 0; next }
  /^# on / { print $3 > (out n ".host"); on = 1; next } on { print > (out n) }' "$page"
blocks=5
if ! [ -e "$scratch/block$blocks" ] || [ -e "$scratch/block$((blocks + 1))" ]; then
  fail "the page has another number of blocks than $blocks"
fi
number() { cut -d. -f3 "$scratch/block$1.host"; }
desk=$scratch/desk # one shell after another: what one exports the next one has
: >"$desk"
typed() { # BLOCK: at the desk
  grep '^export' "$scratch/block$1" >>"$desk" || true
  cat "$desk" "$scratch/block$1" | sed "s/NUMBER/${session:-}/" >"$scratch/typed"
  on "$(number "$1")" bash -euo pipefail "$scratch/typed" >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "block $1 failed"; }
}
said() { grep -q "$1" "$scratch/said" || { cat "$scratch/said"; fail "it does not say '$1'"; }; }

start "$(number 1)" server bash "$scratch/block1"
await event=ready "$scratch/server.log"
typed 2
said 'round trip'
start "$(number 3)" hand bash "$scratch/block3"
await 'server found' "$scratch/hand.log"
typed 4
session=$(sed -n 's/^session \([0-9]*\) stays open.*/\1/p' "$scratch/said")
[ -n "$session" ] || { cat "$scratch/said"; fail "the grasp names no session"; }
said 'armed'
await "following session $session" "$scratch/hand.log"
await '^motors on: ' "$scratch/hand.log"
await "session $session: pose .* reached" "$scratch/hand.log"
lines=$(wc -l <"$scratch/hand.log")
typed 5
for _ in $(seq 300); do
  tail -n +$((lines + 1)) "$scratch/hand.log" | grep -q 'pose .* reached' && break
  sleep 0.1
done
tail -n +$((lines + 1)) "$scratch/hand.log" | grep -q 'index_proximal_flex' || { tail "$scratch/hand.log"; fail "the edit did not move the hand"; }
echo "three_machines_test: passed"
