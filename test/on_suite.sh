#!/usr/bin/env bash
# Runs ./dev demo and ./dev test in another Debian, in a folder made by debootstrap.
# usage: on_suite.sh SUITE FOLDER [CTEST ARGS] <sources.tar       (as root; ./dev test-on calls it)
# FOLDER keeps the suites and their compiler cache for the next time. Ends with 77 where the suite cannot be fetched.
set -euo pipefail
readonly cannot_be_fetched=77

# Mounts are seen in here alone, and go when this ends, however it ends.
if [ "${1-}" != --in-own-mounts ]; then
  exec unshare --mount --propagation private "${BASH_SOURCE[0]}" --in-own-mounts "$@"
fi
shift
suite=$1 folder=$2
shift 2
root=$folder/$suite

say() { printf '\033[1m==> %s: %s\033[0m\n' "$suite" "$*" >&2; }

skip() {
  say "NOT TESTED: $*"
  exit $cannot_be_fetched
}

# Where this machine gets its own Debian packages; others use the mirror of all.
mirror() {
  local own
  own=$(apt-get indextargets --format '$(REPO_URI)' 'Origin: Debian' 'Label: Debian' 2>/dev/null | head -n 1 || true)
  own=${own:-http://deb.debian.org/debian}
  echo "${own%/}"
}

# Whether the suite can be fetched: tells a missing network from a fault of ours.
is_reachable() {
  rm -f "$folder/.$suite.InRelease"
  /usr/lib/apt/apt-helper -qq -o APT::Sandbox::User=root download-file \
    "$(mirror)/dists/$suite/InRelease" "$folder/.$suite.InRelease"
}

in_suite() {
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive TERM="${TERM:-dumb}" \
    ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} ${no_proxy:+no_proxy="$no_proxy"} \
    ${TALUS_JOBS:+TALUS_JOBS="$TALUS_JOBS"} ${TALUS_TEST_ROOMS:+TALUS_TEST_ROOMS="$TALUS_TEST_ROOMS"} \
    ${data:+TALUS_TEST_DATA=/test-data} CCACHE_DIR=/ccache \
    chroot "$root" "$@" 9>&-
}

# Under another name until it is whole.
make_suite() {
  say "debootstrap into $root"
  local new=$folder/.new.$suite
  rm -rf --one-file-system "$new"
  debootstrap --variant=minbase --include=ca-certificates "$suite" "$new" "$(mirror)" >"$folder/$suite.log" 2>&1 || {
    tail -n 5 "$folder/$suite.log" >&2
    is_reachable || skip "$(mirror) cannot be reached any more"
    say "debootstrap failed; all it says is in $folder/$suite.log"
    exit 1
  }
  mv "$new" "$root"
}

# One that was left in the middle of an installation is made anew.
is_sound() {
  [ -d "$root" ] && [ -z "$(chroot "$root" dpkg --audit 2>&1)" ]
}

# The network as this machine has it, its devices, the compiler cache, and logs that some specifications read.
mount_all() {
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  {
    apt-config dump | grep -iE '^Acquire::([a-z]+::(proxy|cainfo|verify|timeout)|retries)' || true
    echo 'Acquire::Check-Valid-Until "false";'  # a mirror that lags behind is as good
  } >"$root/etc/apt/apt.conf.d/99host"
  mkdir -p "$root/ccache" "$folder/ccache" "$root/test-data"
  mount -t proc proc "$root/proc"
  mount --rbind /sys "$root/sys"
  mount --rbind /dev "$root/dev"
  mount --bind "$folder/ccache" "$root/ccache"
  if [ -n "$data" ]; then
    mount --bind "$data" "$root/test-data"
    mount -o remount,bind,ro "$root/test-data"
  fi
}

# The packages of today, and those that ./dev asks for.
install_packages() {
  say "packages"
  in_suite apt-get update -qq -o APT::Update::Error-Mode=any && in_suite apt-get dist-upgrade -y -qq >/dev/null ||
    say "packages cannot be brought up to date; those that are there are taken"
  in_suite apt-get clean
  in_suite /talus/dev install ccache && in_suite apt-get clean || {
    is_reachable || skip "packages cannot be fetched from $(mirror)"
    say "packages that ./dev needs cannot be installed"
    exit 1
  }
}

main() {
  [ -e "/usr/share/debootstrap/scripts/$suite" ] || { say "debootstrap knows no such suite of Debian"; exit 2; }
  data=${TALUS_TEST_DATA:-}
  mkdir -p "$folder"
  exec 9>"$folder/$suite.lock"
  flock --nonblock 9 || { say "waiting for another run in it"; flock 9; }
  if ! is_sound; then
    rm -rf --one-file-system "$root"
    is_reachable || skip "$(mirror)/dists/$suite cannot be fetched. Is there a network, and such a suite of Debian?"
    make_suite
  fi
  rm -rf --one-file-system "$root/talus"
  mkdir "$root/talus"
  tar --extract --no-same-owner --directory "$root/talus"
  mount_all
  install_packages
  say "./dev demo"
  in_suite /talus/dev demo
  say "./dev test"
  in_suite /talus/dev test "$@"
}

main "$@"
