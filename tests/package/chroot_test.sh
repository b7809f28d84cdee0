#!/usr/bin/env bash
# chroot_test.sh PACKAGES SOURCES: installs the Debian packages in a clean Debian 12 (mmdebstrap) that has nothing of the
# sources but its two examples, and works there as a stranger would: commands, manual, completion, unit, the Python
# tutorial, an environment without root, C++ against the dev package, and away with it all.
# 77 where no chroot can be made. HANDGRAFT_CHROOT: a folder to make it in and keep, for the next run.
set -euo pipefail
packages=$(realpath "$1")
source=$(realpath "$2")
fail() { echo "chroot_test: $*" >&2; exit 1; }
skip() { echo "chroot_test: skipped: $*"; exit 77; }
[ "$(id -u)" -eq 0 ] || skip "only root makes a chroot"
command -v mmdebstrap >/dev/null || skip "there is no mmdebstrap"
ls "$packages"/*.deb >/dev/null 2>&1 || fail "there is no package in $packages: ./dev package makes them"

if [ -n "${HANDGRAFT_CHROOT:-}" ]; then
  root=$HANDGRAFT_CHROOT
else
  scratch=$(mktemp -d)
  trap 'rm -rf "$scratch"' EXIT
  root=$scratch/debian
fi
if [ ! -x "$root/bin/bash" ]; then
  mmdebstrap --quiet --mode=root --variant=minbase --include=man-db,bash-completion,systemd,ca-certificates bookworm "$root" ||
    skip "no Debian 12 could be fetched"
fi

# A command in there, as USER: its own processes, mounts and, but for apt, network with nothing but a loopback.
within() { # USER COMMAND...
  local user=$1
  shift
  # shellcheck disable=SC2016
  unshare --net --pid --mount --fork bash -c '
    set -e
    root=$1 user=$2
    shift 2
    ip link set lo up
    mount -t proc proc "$root/proc"
    mount --bind /dev "$root/dev"
    mount -t tmpfs tmpfs "$root/dev/shm"
    exec chroot --userspec="$user" "$root" /usr/bin/env -i PATH=/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin \
      HOME="$(if [ "$user" = root ]; then echo /root; else echo /home/stranger; fi)" LANG=C.UTF-8 "$@"' _ "$root" "$user" "$@"
}
apt() { chroot "$root" /usr/bin/env DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends "$@" >"$root/tmp/apt.log" 2>&1 ||
  { tail -20 "$root/tmp/apt.log"; fail "apt-get $* failed"; }; }
grep -q ^stranger: "$root/etc/passwd" || chroot "$root" useradd --create-home --uid 4242 stranger

rm -rf "$root/packages" "$root/stranger"
mkdir -p "$root/packages" "$root/stranger"
cp "$packages"/*.deb "$root/packages"
cp "$source/tests/package/stranger.cpp" "$root/stranger/live.cpp"
cp "$source/core/examples/grasp_point_pairs.cpp" "$root/stranger/poses.cpp"
# The tutorial as it stands in the module's README.
# shellcheck disable=SC2016
sed -n '/^```python$/,/^```$/{/^```/d;p}' "$source/client/python/README.md" >"$root/stranger/tutorial.py"
grep -q watch "$root/stranger/tutorial.py" || fail "there is no tutorial in client/python/README.md"
named() { (cd "$root" && ls packages/"$1"_*.deb) | sed 's|^|/|'; }

# === What a user installs
apt update
# shellcheck disable=SC2046
apt install $(named handgraft) $(named handgraft-server) $(named handgraft-bridge) $(named python3-handgraft)
for program in handgraft handgraft-server handgraft-bridge; do
  within stranger "$program" --version >/dev/null || fail "$program does not start"
  within stranger man --pager=cat "$program" | grep -q SYNOPSIS || fail "there is no manual page of $program"
done
within stranger bash -c 'cd && rm -rf .cache .local && time handgraft grasp --hand human20 --object lemon --contacts lemon_6' \
  >"$root/tmp/grasp.txt" 2>&1 || { cat "$root/tmp/grasp.txt"; fail "the first grasp failed"; }
grep -q 'patches reached' "$root/tmp/grasp.txt" || fail "the first grasp says no verdict"
echo "first grasp: $(sed -n 's/^real\s*//p' "$root/tmp/grasp.txt")"
within stranger bash -c 'cd && handgraft-server & sleep 2; handgraft doctor && handgraft models && handgraft view --help >/dev/null; kill %1; wait' \
  >"$root/tmp/server.txt" 2>&1 || { cat "$root/tmp/server.txt"; fail "the server did not answer"; }
grep -q lemon_6 "$root/tmp/server.txt" || fail "the server has no built-in models"
# shellcheck disable=SC2016
offered=$(within stranger bash -c '
  source /usr/share/bash-completion/bash_completion
  _completion_loader handgraft
  COMP_WORDS=(handgraft gra) COMP_CWORD=1
  _handgraft
  echo "${COMPREPLY[*]}"')
[ "$offered" = grasp ] || fail "completion offered '$offered'"
unit=/usr/share/doc/handgraft/examples/handgraft-server.service
if ! within root systemd-analyze verify "$unit" >"$root/tmp/unit.txt" 2>&1 || grep -q handgraft-server "$root/tmp/unit.txt"; then
  cat "$root/tmp/unit.txt"
  fail "systemd objects to the unit"
fi

# === Python, of the system and in an environment without root
within stranger bash -c 'cd && python3 /stranger/tutorial.py' >"$root/tmp/tutorial.txt" 2>&1 ||
  { tail -20 "$root/tmp/tutorial.txt"; fail "the Python tutorial failed"; }
apt install python3-venv
# shellcheck disable=SC2016
within stranger bash -c '
  set -e
  cd
  rm -rf environment
  python3 -m venv --system-site-packages environment
  environment/bin/python -c "import handgraft; print(handgraft.connect().grasp(\"barrett8\", \"lemon\", \"lemon_3\").verdict)"' \
  >"$root/tmp/environment.txt" 2>&1 || { cat "$root/tmp/environment.txt"; fail "a virtual environment failed"; }

# === What a programmer installs
# shellcheck disable=SC2046
apt install g++ cmake ninja-build $(named libhandgraft-dev)
cat >"$root/stranger/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(stranger LANGUAGES CXX)
find_package(handgraft REQUIRED COMPONENTS core client)
add_executable(live live.cpp)
target_link_libraries(live PRIVATE handgraft::client)
add_executable(poses poses.cpp)
target_link_libraries(poses PRIVATE handgraft::core)
END
models=/usr/share/handgraft/models
within stranger bash -c "
  set -e
  cd
  rm -rf build
  cmake -S /stranger -B build -G Ninja -DCMAKE_BUILD_TYPE=Release
  cmake --build build
  build/poses $models/hands/barrett8/barrett8.urdf $models/objects/lemon.obj
  build/live 0" >"$root/tmp/programs.txt" 2>&1 || { tail -20 "$root/tmp/programs.txt"; fail "C++ against libhandgraft-dev failed"; }

# === And away
apt purge handgraft handgraft-server handgraft-bridge python3-handgraft libhandgraft-dev
left=$(cd "$root" && find usr etc -path '*handgraft*' | head -5)
[ -z "$left" ] || fail "purged packages leave $left"
echo "chroot_test: passed"
