#!/usr/bin/env bash
# containers.sh images|up|down: the images and what compose.yaml makes of them, by docker or podman; ./dev runs it.
# HANDGRAFT_BUILD_OPTIONS: more options for the engine's build, e.g. -v of a compiler's cache or of certificates.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
project=${HANDGRAFT_PROJECT:-handgraft}
targets=(server client page bridge emulated-hand)

fail() { echo "containers: $*" >&2; exit 1; }

# shellcheck source=docker/engine.sh
. docker/engine.sh || fail "neither docker nor podman runs here (Debian: podman podman-compose netavark aardvark-dns)"

hasNetworks() { "$engine" network inspect "${project}_handgraft" >/dev/null 2>&1; }
own() { "$engine" ps -a --format '{{.Names}}' | grep -E "^${project}[_-](server|bridge|page)[_-][0-9]+\$" || true; }

case ${1:-} in
images)
  mkdir -p build/images
  options=()
  if [ "$engine" = podman ] && [[ ${HANDGRAFT_BUILD_OPTIONS:-} != *:/var/cache/ccache* ]]; then
    mkdir -p build/images/ccache
    options=(-v "$PWD/build/images/ccache:/var/cache/ccache")
  fi
  read -ra more <<<"${HANDGRAFT_BUILD_OPTIONS:-}"
  options+=("${more[@]}")
  base=$("$engine" image inspect --format '{{.Size}}' debian:bookworm-slim 2>/dev/null || echo 0)
  for target in build base "${targets[@]}"; do
    begun=$SECONDS
    "$engine" build "${options[@]}" -f docker/Dockerfile --target "$target" -t "handgraft-$target" . \
      >"build/images/$target.log" 2>&1 || { tail -20 "build/images/$target.log" >&2; fail "the image $target is not built; see build/images/$target.log"; }
    printf '%-24s %4d s' "handgraft-$target" $((SECONDS - begun))
    size=$("$engine" image inspect --format '{{.Size}}' "handgraft-$target")
    [ "$target" = build ] || printf ' %6d MB, %d above Debian' $((size / 1000000)) $(((size - base) / 1000000))
    echo
  done
  for target in "${targets[@]}"; do
    "$engine" run --rm --no-healthcheck --network none --entrypoint cat "handgraft-$target" /usr/local/share/packages.txt >"build/images/$target.packages"
  done
  echo "packages of each are listed in build/images/*.packages"
  ;;
up)
  for target in server page emulated-hand; do
    "$engine" image inspect "handgraft-$target" >/dev/null 2>&1 || { "$0" images; break; }
  done
  "${compose[@]}" -p "$project" -f docker/compose.yaml up -d --no-build >build/images/up.log 2>&1 ||
    { tail -20 build/images/up.log >&2; fail "compose does not start it"; }
  page=$("$engine" ps -a --format '{{.Names}}' | grep -E "^${project}[_-]page[_-]1\$" || true)
  for _ in $(seq 300); do
    link=$("$engine" logs "$page" 2>/dev/null | grep -m1 '^http://' || true)
    [ -n "$link" ] && break
    sleep 0.1
  done
  [ -n "$link" ] || { "$engine" logs "$page" >&2 || true; fail "the page does not come up within 30 s"; }
  # The container knows neither its host's name nor the port that leads to it.
  echo "the page: http://localhost:${HANDGRAFT_PORT:-8080}/${link##*/}"
  echo "commands: $engine exec ${page/page/server} handgraft grasp --hand barrett8 --object lemon --contacts lemon_6 --keep"
  echo "          $engine exec ${page/page/bridge} handgraft bridge arm; ./dev down ends it"
  ;;
down)
  "${compose[@]}" -p "$project" -f docker/compose.yaml down -v -t 10 >/dev/null 2>&1 || true
  # podman-compose leaves these behind; and whoever ran a command of his own on the network may still be on it.
  if [ "$engine" = podman ]; then
    podman pod rm -f "pod_$project" >/dev/null 2>&1 || true
    podman pod rm -f "$project" >/dev/null 2>&1 || true
    own | xargs -r podman rm -f -t 10 >/dev/null 2>&1 || true
    ! hasNetworks || podman network rm -f -t 10 "${project}_handgraft" >/dev/null
    podman volume rm -f "${project}_state" >/dev/null 2>&1 || true
  fi
  left=$(own)
  [ -z "$left" ] || fail "left over: $left"
  ! hasNetworks || fail "the network ${project}_handgraft is left over"
  ;;
*) fail "usage: containers.sh images|up|down" ;;
esac
