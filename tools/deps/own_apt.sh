# shellcheck shell=bash
# Sourced: an apt of our own, that knows other packages than the system's and changes nothing of it.

# debian_archive: the address of the Debian archive that this machine already uses, or nothing. Asked
# without apt writing its caches.
debian_archive() {
  # shellcheck disable=SC2016  # $(REPO_URI) is for apt
  apt-get -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= indextargets \
    --format '$(REPO_URI)' 'Component: main' 2> /dev/null | grep -m 1 '/debian/$' || true
}

# make_apt FOLDER LINE...: its folders, list of sources (the lines) and list of installed packages
# (none) lie in FOLDER. For the processor in the variable `architecture`, or else amd64. Of this
# system's settings only those for downloading are kept, such as a proxy.
make_apt() {
  local apt=$1/apt
  shift
  mkdir -p "$apt/etc/apt/apt.conf.d" "$apt/etc/apt/sources.list.d" "$apt/etc/apt/preferences.d" \
    "$apt/var/lib/apt/lists/partial" "$apt/var/cache/apt/archives/partial" "$apt/var/log/apt"
  : > "$apt/status"
  {
    apt-config dump | grep '^Acquire::' || true
    cat <<CONF
APT::Update::Error-Mode "any";
Acquire::Retries "1";
Acquire::http::Timeout "20";
Acquire::https::Timeout "20";
APT::Architecture "${architecture:-amd64}";
APT::Architectures { "${architecture:-amd64}"; };
Dir "$apt/";
Dir::State "var/lib/apt";
Dir::State::status "$apt/status";
Dir::Cache "var/cache/apt";
Dir::Etc "etc/apt";
Dir::Log "var/log/apt";
CONF
    # As root apt would change to a user who may not read our folders
    if [ "$(id -u)" = 0 ]; then echo 'APT::Sandbox::User "root";'; fi
  } > "$apt/apt.conf"
  printf '%s\n' "$@" > "$apt/etc/apt/sources.list"
}

# own_apt FOLDER ARGUMENT...: what it says goes to FOLDER/log.
own_apt() {
  local work=$1
  shift
  APT_CONFIG=$work/apt/apt.conf DEBIAN_FRONTEND=noninteractive LC_ALL=C apt-get -qq "$@" \
    < /dev/null > "$work/log" 2>&1
}

# fetch_sources WORK NAME=VERSION...: the source packages of Debian 12, unpacked into WORK/sources.
# Prints why where it fails.
fetch_sources() {
  local work=$1 archive tool keyring=/usr/share/keyrings/debian-archive-keyring.gpg
  shift
  for tool in apt-get dpkg-source; do
    command -v "$tool" > /dev/null || { echo "$tool is missing: package dpkg-dev" >&2; return 1; }
  done
  archive=$(debian_archive)
  [ -n "$archive" ] || { echo "this machine's apt knows no Debian archive" >&2; return 1; }
  make_apt "$work" "deb-src [signed-by=$keyring] $archive bookworm main"
  mkdir -- "$work/sources"
  if ! own_apt "$work" update || ! (cd -- "$work/sources" && own_apt "$work" source "$@"); then
    tail -n 3 "$work/log" >&2
    return 1
  fi
}
