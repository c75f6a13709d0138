# shellcheck shell=bash
# For the scripts of tests/app: one line a check, which tests/app/run counts.
#   ok NAME / FAILED NAME: what was found / skipped NAME: why

# check NAME COMMAND...: ok if the command succeeds; otherwise what it wrote.
check() {
  local name=$1 said
  shift
  if said=$("$@" 2>&1); then
    echo "ok $name"
  else
    echo "FAILED $name: ${said:-no reason given}"
  fi
}

# same HAVE WANT: for check.
same() {
  [ "$1" = "$2" ] || {
    echo "is '$1', expected '$2'"
    return 1
  }
}

# has TEXT PART: for check; PART as it is.
has() {
  case $1 in *"$2"*) ;; *)
    echo "no '$2' in: ${1:0:300}"
    return 1
    ;;
  esac
}
