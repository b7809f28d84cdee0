#!/usr/bin/env bash
# secured_test.sh PROGRAMS DOMAIN OTHER_CLOCK: a secured domain as a lab uses it. Each role does what it may, by programs of both
# vendors and in either order of starts; strangers see nothing of a session, change nothing, and are told why.
set -euo pipefail
bin=$(realpath "$1")
export HANDGRAFT_DOMAIN=$2
other_clock=$(realpath "$3")
unset HANDGRAFT_IDENTITY
# shellcheck source=tests/system/programs.sh
. "$(dirname "${BASH_SOURCE[0]}")/programs.sh"
umask 022
keys=$scratch/keys
as() { # NAME COMMAND...: a command of `handgraft` under an identity
  HANDGRAFT_IDENTITY=$keys/$1 timeout 60 "$bin/handgraft" "${@:2}"
}
says() { # WORDS COMMAND...: fails, and says so
  local words=$1
  shift
  if "$@" >"$scratch/said" 2>&1; then
    cat "$scratch/said" >&2
    fail "'$*' was not refused"
  fi
  grep -q -e "$words" "$scratch/said" || { cat "$scratch/said" >&2; fail "'$*' does not say '$words'"; }
}

five_days_ago() { # COMMAND...: by a clock that is late
  env LD_PRELOAD="$other_clock" HANDGRAFT_CLOCK_OFFSET_S=-432000 ASAN_OPTIONS="${ASAN_OPTIONS:-}:verify_asan_link_order=0" "$@"
}

five_days_ago "$bin/handgraft" keys init "$keys" >"$scratch/said"
five_days_ago "$bin/handgraft" keys add old --role operator --days 2 --dir "$keys" >"$scratch/said"
for role in server operator editor viewer hand; do
  "$bin/handgraft" keys add "a-$role" --role "$role" --dir "$keys" >"$scratch/said"
done
"$bin/handgraft" keys add b-editor --role editor --dir "$keys" >"$scratch/said"
"$bin/handgraft" keys add b-operator --role operator --dir "$keys" >"$scratch/said"
"$bin/handgraft" keys add gone --role editor --dir "$keys" >"$scratch/said"
cp -r "$keys/gone" "$scratch/late" # its owner never hears that it was revoked
cp -r "$keys/old" "$scratch/old" # nor its owner that anything was
"$bin/handgraft" keys revoke gone --dir "$keys" >"$scratch/said"
mkdir "$scratch/others"
"$bin/handgraft" keys init "$scratch/others/keys" >"$scratch/said"
"$bin/handgraft" keys add a-editor --role editor --dir "$scratch/others/keys" >"$scratch/said"
"$bin/handgraft" keys show --dir "$keys" --json >"$scratch/show"
if [ "$(grep -c '"state": "valid"' "$scratch/show")" != 7 ] || ! grep -q '"state": "revoked"' "$scratch/show" ||
  ! grep -q '"state": "expired"' "$scratch/show"; then
  cat "$scratch/show"
  fail "keys show"
fi

# === Clients first: a hand waits for the server, an editor asks while it starts
start hand "$bin/handgraft-bridge" --identity "$keys/a-hand" --disarmed
start spy "$bin/handgraft-bridge" --bridge-id 9 --disarmed # who follows whatever is heard, without an identity
spy=${pids[-1]}
await 'simulated hand' "$scratch/hand.log"
for _ in 1 2 3 4 5; do # a command waits for 2 s
  HANDGRAFT_IDENTITY=$keys/a-editor "$bin/handgraft" models && break
done >"$scratch/models" 2>&1 &
early=$!
sleep 0.2
start server "$bin/handgraft-server" --identity "$keys/a-server"
await event=ready "$scratch/server.log"
wait "$early" || { cat "$scratch/models"; fail "an editor that was there before the server was not answered"; }

# === Server first: a grasp, an edit, and what the hand makes of it
as a-editor grasp --hand barrett8 --object lemon --contacts lemon_6 --keep --json >"$scratch/grasp" 2>&1 ||
  { cat "$scratch/grasp"; fail "no grasp by an editor"; }
session=$(sed -n 's/.*"session_id": *\([0-9]*\).*/\1/p' "$scratch/grasp" | head -1)
await "session $session" "$scratch/hand.log"
revision() { as a-editor sessions --json | sed -n 's/.*"revision": *\([0-9]*\).*/\1/p' | head -1; }
before=$(revision)
echo 'dir thumb 10deg' >"$scratch/turn"
as a-editor edit "$session" --script "$scratch/turn" >"$scratch/edit" 2>&1 || { cat "$scratch/edit"; fail "no edit"; }
[ "$(revision)" -gt "$before" ] || { cat "$scratch/edit"; fail "the edit changed nothing"; }

# === A viewer looks, and nothing else
as a-viewer sessions --json >"$scratch/sessions"
grep -q "$session" "$scratch/sessions" || { cat "$scratch/sessions"; fail "a viewer does not see the session"; }
as a-viewer watch "$session" --count 1 >"$scratch/watch" 2>&1 || { cat "$scratch/watch"; fail "a viewer cannot watch"; }
as a-viewer bridge status >"$scratch/status" || fail "a viewer cannot see the bridge"
as a-viewer export "$session" --format csv --out "$scratch/pose.csv" >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "a viewer cannot export"; }
as a-viewer doctor >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "a viewer's doctor"; }
grep -q "change nothing" "$scratch/said" || { cat "$scratch/said"; fail "doctor does not say what a viewer may"; }
before=$(revision)
says 'viewer, which may not' as a-viewer close "$session"
says 'viewer, which may not' as a-viewer edit "$session" --script "$scratch/turn"
says 'viewer, which may not' as a-viewer bridge arm
says 'operators and editors' as a-viewer grasp --hand barrett8 --object lemon --contacts lemon_6

# === A session is its opener's; others edit it once it is shared with them
before=$(revision)
says 'is a-editor' as b-editor edit "$session" --script "$scratch/turn"
says 'not shared with b-editor' as b-editor close "$session"
says "is for its owner or an operator to say" as b-editor session share "$session" everyone
[ "$(revision)" = "$before" ] || fail "an editor changed another one's session"
as a-editor session share "$session" b-editor >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "no sharing"; }
as b-editor edit "$session" --script "$scratch/turn" >"$scratch/edit" 2>&1 || { cat "$scratch/edit"; fail "no edit of a shared session"; }
[ "$(revision)" -gt "$before" ] || { cat "$scratch/edit"; fail "the edit changed nothing"; }
as a-viewer sessions | grep -q 'a-editor *owner and others' || { as a-viewer sessions; fail "whose it is is not told"; }
as a-editor session share "$session" nobody >"$scratch/said"
says 'is a-editor' as b-editor edit "$session" --script "$scratch/turn"
as a-operator edit "$session" --script "$scratch/turn" >"$scratch/edit" 2>&1 || { cat "$scratch/edit"; fail "no edit by an operator"; }

# === What is for operators
cat >"$scratch/cube.obj" <<'END'
v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
END
as a-editor load object "$scratch/cube.obj" --name cube >"$scratch/load" 2>&1 || { cat "$scratch/load"; fail "no load"; }
says 'editor, which may not' as a-editor unload object cube
as a-operator unload object cube >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "an operator may not unload"; }
state() { as a-viewer bridge status --json | sed -n 's/.*"state": *"\([a-z]*\)".*/\1/p' | head -1; }
[ "$(state)" = idle ] || fail "the hand is $(state) before anybody armed it"
says 'editor, which may not' as a-editor bridge arm
[ "$(state)" = idle ] || fail "the hand obeyed an editor"
as a-operator bridge arm >"$scratch/arm" 2>&1 || { cat "$scratch/arm"; fail "the hand does not obey an operator"; }
[ "$(state)" = armed ] || fail "the hand is $(state) after ARM"

# === Strangers
before=$(revision)
kill "$spy"
wait "$spy" || true
stranger() { # [BEFORE]: under HANDGRAFT_IDENTITY
  says 'no handgraft-server' "$@" timeout 60 "$bin/handgraft" models
  says 'no handgraft-server' "$@" timeout 60 "$bin/handgraft" close "$session"
  says 'no handgraft-bridge' "$@" timeout 60 "$bin/handgraft" bridge disarm
}
stranger
HANDGRAFT_IDENTITY=$scratch/others/keys/a-editor stranger
HANDGRAFT_IDENTITY=$scratch/late stranger
says 'was revoked on' as gone models
says 'expired on' as old models
# Nor does it help him that his own program believes him.
HANDGRAFT_IDENTITY=$scratch/old stranger five_days_ago
says 'a secured program is there' "$bin/handgraft" models
says 'is no folder' as nobody models
chmod 644 "$scratch/late/key.pem"
says "key.pem: others than its owner may read" "$bin/handgraft" models --identity "$scratch/late"
says 'is of role server' as a-server models
for role in operator hand; do
  says "is of role $role" "$bin/handgraft-server" --identity "$keys/a-$role"
done
says 'is of role editor' "$bin/handgraft-bridge" --identity "$keys/a-editor"
# A server without an identity, and one of another authority, are not met by who has one.
grep -q "$session" "$scratch/spy.log" && { cat "$scratch/spy.log"; fail "a stranger heard of the session"; }
[ "$(revision)" = "$before" ] || fail "a stranger changed the session"
[ "$(state)" = armed ] || fail "a stranger changed the hand"
grep -q level=error "$scratch/server.log" && { cat "$scratch/server.log"; fail "the server logs errors"; }

# === Who is revoked while all run: the server hears of it, and nothing of him any more
as a-editor session share "$session" b-editor >"$scratch/said"
cp -r "$keys/b-editor" "$scratch/taken"
mkfifo "$scratch/line"
exec 9<>"$scratch/line"
before=$(revision)
is_past() { [ "$(revision)" -gt "$1" ]; }
HANDGRAFT_IDENTITY=$scratch/taken "$bin/handgraft" edit "$session" <"$scratch/line" >"$scratch/editing" 2>&1 &
pids+=($!)
echo 'weight palm 0.5' >&9
await_that is_past "$before" || { cat "$scratch/editing"; fail "who is not revoked yet cannot edit"; }
before=$(revision)
"$bin/handgraft" keys revoke b-editor --dir "$keys" >"$scratch/said"
await 'event=revocations_read count=2' "$scratch/server.log"
echo 'weight palm 0.75' >&9
HANDGRAFT_IDENTITY=$scratch/taken says 'no handgraft-server' timeout 60 "$bin/handgraft" models
[ "$(revision)" = "$before" ] || { cat "$scratch/editing"; fail "one who was revoked edits on"; }
as a-editor edit "$session" --script "$scratch/turn" >"$scratch/edit" 2>&1 || { cat "$scratch/edit"; fail "others are not let in any more"; }

# === The hand and clients that run hear of it, too
cp -r "$keys/b-operator" "$scratch/stolen"
HANDGRAFT_IDENTITY=$scratch/stolen timeout 60 "$bin/handgraft" bridge disarm >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "the hand does not obey a second operator"; }
as a-operator bridge arm >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "the hand does not obey an operator any more"; }
"$bin/handgraft" keys revoke b-operator --dir "$keys" >"$scratch/said"
await 'event=revocations_read count=3' "$scratch/server.log"
for _ in 1 2 3; do # the hand looks once a second
  HANDGRAFT_IDENTITY=$scratch/stolen timeout 60 "$bin/handgraft" bridge disarm >"$scratch/said" 2>&1 && as a-operator bridge arm >"$scratch/arm" 2>&1
done
HANDGRAFT_IDENTITY=$scratch/stolen says 'no handgraft-bridge' timeout 60 "$bin/handgraft" bridge disarm
[ "$(state)" = armed ] || fail "the hand obeyed an operator who was revoked"
as a-operator bridge disarm >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "the hand does not obey who is left"; }
as a-editor close "$session" >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "the session is not there"; }

# === Several servers, and motors off the loopback: the same as in an open domain
start named "$bin/handgraft-server" --identity "$keys/a-server" --name left
await event=ready "$scratch/named.log"
as a-editor models --server left >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "no server of a name"; }
echo "secured_test: passed"
