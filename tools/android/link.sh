# shellcheck shell=sh disable=SC2154,SC2086,SC2046
# The end of the compiler's wrapper (tools/android/toolchain), which has set zig and the arguments. Zig's
# driver refuses some options of its own linker: it links without them and says how it called lld, which
# is called again with them. It says so without quotes, so not where names have spaces.
more=''
count=$#
while [ "$count" -gt 0 ]; do
  case $1 in
    -Wl,--pack-dyn-relocs=* | -Wl,--icf=*) more="$more ${1#-Wl,}" ;;
    *) set -- "$@" "$1" ;;
  esac
  shift
  count=$((count - 1))
done
case $PWD$zig in *' '*) more='' ;; esac
if [ -z "$more" ]; then exec "$zig" "$@"; fi
if ! said=$("$zig" "$@" --verbose 2>&1); then
  printf '%s\n' "$said" | grep -v '^ld\.lld ' >&2
  exit 1
fi
set -f
exec "$zig" ld.lld $(printf '%s\n' "$said" | sed -n 's/^ld\.lld //p') $more
