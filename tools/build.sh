# shellcheck shell=bash
# Sourced by tools/quickstart and tools/test: configuring and building a preset.

# Compilers at once: as many as there are cores and 1.5 GB each.
jobs() {
  awk -v cores="$(nproc)" '/^MemAvailable/ { n = int($2 / 1500000) }
    END { if (n > cores || !n) n = cores; print n }' /proc/meminfo 2> /dev/null || nproc
}

# build_preset PRESET [--target NAME...]
build_preset() {
  local preset=$1 cache=build/$1/CMakeCache.txt fresh=()
  shift
  # A checkout that was moved or copied with its build folder
  if [ -f "$cache" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" "$cache"; then
    fresh=(--fresh)
  fi
  cmake --preset "$preset" "${fresh[@]}" -Wno-dev --log-level=WARNING &&
    cmake --build "build/$preset" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(jobs)}" "$@"
}
