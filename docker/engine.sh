# shellcheck shell=bash disable=SC2034  # who sources this uses what it sets
# To be sourced at the project's root: `engine` and `compose`, docker or podman; fails where there is neither.
if docker info >/dev/null 2>&1; then
  engine=docker
  compose=(docker compose)
elif command -v podman >/dev/null && command -v podman-compose >/dev/null; then
  engine=podman
  compose=(podman-compose)
  export BUILDAH_FORMAT=docker # else health checks are dropped without a word
  # A machine that is a container itself lets podman neither raise limits nor ask systemd.
  if [ "$(id -u)" = 0 ] && [ -z "${CONTAINERS_CONF:-}" ] && ! [ -d /run/systemd/system ]; then
    export CONTAINERS_CONF=$PWD/docker/containers.conf BUILDAH_ISOLATION=chroot
  fi
else
  false
fi
