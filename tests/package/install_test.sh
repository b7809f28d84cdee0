#!/usr/bin/env bash
# Installs a build into a scratch prefix, and builds and runs programs against it as a stranger would:
# find_package, handgraft::client, handgraft::core. install_test.sh BUILD_FOLDER SOURCE_FOLDER DOMAIN
set -euo pipefail
build=$(realpath "$1")
source=$(realpath "$2")
domain=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
fail() { echo "install_test: $*" >&2; exit 1; }

cmake --install "$build" --prefix "$scratch/usr" >"$scratch/install.log" || { tail -5 "$scratch/install.log"; fail "cmake --install failed"; }

# === What a person finds
for file in bin/handgraft bin/handgraft-server bin/handgraft-reader bin/handgraft-bridge \
  share/man/man1/handgraft.1 share/man/man1/handgraft-server.1 share/man/man1/handgraft-bridge.1 \
  share/bash-completion/completions/handgraft share/zsh/vendor-completions/_handgraft \
  share/doc/handgraft/examples/handgraft-server.service share/handgraft/models/objects/lemon.obj \
  share/doc/handgraft/README.md share/doc/handgraft/client/cli/COMMANDS.md share/doc/handgraft/client/editor/COMMANDS.md \
  share/doc/handgraft/core/io/FORMATS.md include/handgraft/client.h include/handgraft/core.h \
  share/doc/handgraft/client/examples/live_grasp.cpp share/doc/handgraft/core/examples/grasp_point_pairs.cpp; do
  [ -e "$scratch/usr/$file" ] || fail "$file was not installed"
done
(cd "$source/idl" && find . -name '*.idl') | while read -r file; do
  cmp -s "$source/idl/$file" "$scratch/usr/share/handgraft/idl/$file" || fail "idl/$file was not installed as it is"
done
version=$("$scratch/usr/bin/handgraft" --version)
[[ $version == handgraft\ * ]] || fail "handgraft --version said '$version'"

# Every command that the program has is in its page, and completion offers it.
commands=$("$scratch/usr/bin/handgraft" --help | sed -n '/^Subcommands:/,$ s/^  \([a-z][a-z-]*\) .*/\1/p')
[ -n "$commands" ] || fail "handgraft --help lists no command"
for command in $commands; do
  grep -qE "(^|[^a-z])$command([^a-z]|$)" "$scratch/usr/share/man/man1/handgraft.1" || fail "the manual page does not name '$command'"
done
for step in $("$scratch/usr/bin/handgraft" motion --help | sed -n '/^Subcommands:/,$ s/^  \([a-z][a-z-]*\) .*/\1/p'); do
  grep -q "motion $step" "$scratch/usr/share/man/man1/handgraft.1" || fail "the manual page does not name 'motion $step'"
done
offered=$(PATH="$scratch/usr/bin:$PATH" bash -c '
  source "$1"
  COMP_WORDS=(handgraft gra) COMP_CWORD=1
  _handgraft
  echo "${COMPREPLY[*]}"
  COMP_WORDS=(handgraft grasp --han) COMP_CWORD=2
  _handgraft
  echo "${COMPREPLY[*]}"' _ "$scratch/usr/share/bash-completion/completions/handgraft")
[ "$offered" = "grasp"$'\n'"--hand" ] || fail "completion offered '$offered'"

# === What a program finds
cat >"$scratch/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(stranger LANGUAGES CXX)
find_package(handgraft REQUIRED COMPONENTS core client)
add_executable(live live.cpp)
target_link_libraries(live PRIVATE handgraft::client)
add_executable(poses poses.cpp)
target_link_libraries(poses PRIVATE handgraft::core)
END
cp "$source/tests/package/stranger.cpp" "$scratch/live.cpp"
cp "$scratch/usr/share/doc/handgraft/core/examples/grasp_point_pairs.cpp" "$scratch/poses.cpp"
cmake -S "$scratch" -B "$scratch/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$scratch/usr" \
  >"$scratch/configure.log" 2>&1 || { tail -20 "$scratch/configure.log"; fail "a stranger's project does not configure"; }
grep -q "$source" "$scratch"/usr/lib/*/cmake/handgraft/*.cmake "$scratch"/usr/lib/cmake/handgraft/*.cmake 2>/dev/null &&
  fail "the installed package names the source folder"
cmake --build "$scratch/build" >"$scratch/build.log" 2>&1 || { tail -20 "$scratch/build.log"; fail "a stranger's project does not build"; }
models="$scratch/usr/share/handgraft/models"
"$scratch/build/poses" "$models/hands/barrett8/barrett8.urdf" "$models/objects/lemon.obj" || fail "the core's example failed"
PATH="$scratch/usr/bin:$PATH" "$scratch/build/live" "$domain" || fail "the client's program failed"

if [ -e "$scratch/usr/lib/python3/dist-packages/handgraft/__init__.py" ]; then
  PYTHONPATH="$scratch/usr/lib/python3/dist-packages" /usr/bin/python3 -c 'import handgraft; handgraft.connect' ||
    fail "the Python module does not load"
fi
echo "install_test: passed"
