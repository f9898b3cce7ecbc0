#!/usr/bin/env bash
# Makes the Debian packages of a build, installs them into a fresh folder, and tries what they bring: commands on a log, the
# plugin in rawlog-edit, a program that finds the libraries. Then removes them: nothing may be left.
#   packages.sh BUILD SCRATCH [CMAKE...]
# 77: it cannot be tried here.
set -euo pipefail
build=$(realpath "$1") scratch=$2 here=$(realpath "$(dirname "$0")")
shift 2
for tool in cpack dpkg dpkg-shlibdeps rawlog-edit; do
  command -v "$tool" >/dev/null || { echo "not tried: there is no $tool"; exit 77; }
done
rm -rf "$scratch"
mkdir -p "$scratch/root" "$scratch/dpkg/updates" "$scratch/dpkg/info"
touch "$scratch/dpkg/status" "$scratch/dpkg/available"
scratch=$(realpath "$scratch")

say() { printf -- '-- %s\n' "$*"; }
stop() { echo "packages: $*" >&2; exit 1; }
into() {  # dpkg of a folder: what other packages have to be there is not looked at
  dpkg --instdir="$scratch/root" --admindir="$scratch/dpkg" --log="$scratch/dpkg.log" --force-not-root --force-depends \
    --force-script-chrootless --force-bad-path "$@" >"$scratch/dpkg.txt" 2>&1 || { cat "$scratch/dpkg.txt"; stop "dpkg $1"; }
}

say "making"
(cd "$build" && cpack -G DEB -B "$scratch/made" >"$scratch/cpack.txt" 2>&1) || { tail -20 "$scratch/cpack.txt"; stop "cpack"; }
mapfile -t debs < <(find "$scratch/made" -name '*.deb' | sort)
count=3
[ ! -e "$build/python/talus" ] || count=$((count + 1))
[ ! -e "$build/bin/talus-live" ] || count=$((count + 1))
[ ${#debs[@]} -eq $count ] || stop "not $count packages: ${debs[*]}"
for deb in "${debs[@]}"; do
  dpkg-deb --field "$deb" Package Version Depends | cut -c 1-110
done
dpkg-deb --field "$(find "$scratch/made" -name 'talus_*.deb')" Depends | grep -q libmrpt || stop "talus needs no MRPT?"
for name in talus talus-mrpt-plugin; do  # both write pictures
  dpkg-deb --field "$(find "$scratch/made" -name "${name}_*.deb")" Depends | grep -q fonts-dejavu-core ||
    stop "$name needs no letters?"
done

if command -v lintian >/dev/null; then
  say "lintian"
  (cd "$scratch/made" && lintian --allow-root --fail-on error,warning "${debs[@]}") >"$scratch/lintian.txt" 2>&1 ||
    { cat "$scratch/lintian.txt"; stop "lintian"; }
fi

say "installing"
into --install "${debs[@]}"
root=$scratch/root/usr
export PATH=$root/bin:$PATH
cd "$scratch"

say "mapping a log"
cat >flat.yaml <<'END'
ground: [plane: {}]
robot: {path_m: [[0, 0], [1, 0]]}
END
talus-sim flat.yaml --output drive >/dev/null
talus-map drive/flat.rawlog --backend cpu --config "$root/share/talus/configs/talus-map.ini" --output map \
  --rawlog-out terrain.rawlog --quiet
[ -s map/site.tif ] && [ -s map/map.png ] || stop "no map"
talus-map --version
if [ -e "$build/man/talus-map.1.gz" ]; then
  zgrep -q resume "$root/share/man/man1/talus-map.1.gz" || stop "no manual"
  for command in "$root"/bin/*; do
    zgrep -q "^$(basename "$command" | sed 's/-/\\\\-/g') .* [a-z]" "$root/share/man/man1/$(basename "$command").1.gz" ||
      stop "the manual of $(basename "$command") does not say what it does"
  done
fi
for command in "$root"/bin/*; do
  [ -e "$root/share/bash-completion/completions/$(basename "$command")" ] || stop "no completion of $(basename "$command")"
done
talus-sim "$root/share/talus/worlds/demo.yaml" --output demo --frames 2 --quiet || stop "no worlds"
[ -x "$root/bin/talus-batch" ] || stop "no talus-batch"

say "the plugin in rawlog-edit"
plugin=$(find "$root" -name libtalus-mrpt.so)
LD_LIBRARY_PATH=$(dirname "$plugin") rawlog-edit -p libtalus-mrpt.so --info -i terrain.rawlog >info.txt 2>&1
grep -q "terrain / *11 " info.txt || { cat info.txt; stop "rawlog-edit"; }

if [ $count -eq 4 ]; then
  say "import talus"
  PYTHONPATH=$root/lib/python3/dist-packages /usr/bin/python3 -B -c "import talus; print(talus.Map(backend='cpu')['ground'].shape)"
fi

say "a program of one's own"
cmake -S "$here" -B consumer -DCMAKE_PREFIX_PATH="$root" -DCMAKE_BUILD_TYPE=Release "$@" >/dev/null
cmake --build consumer >consumer.txt 2>&1 || { tail -20 consumer.txt; stop "the consumer"; }
consumer/consumer
consumer/only_linked

say "removing"
mapfile -t names < <(printf '%s\n' "${debs[@]##*/}" | cut -d_ -f1)
into --purge "${names[@]}"
left=$(find "$scratch/root" -not -type d)
[ -z "$left" ] || stop "left: $left"
echo "nothing left"
