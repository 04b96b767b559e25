#!/usr/bin/env bash
# Installs RF-NAV as a service of this computer, or upgrades the one that is there (docs/install.md).
#
#   install.sh [--wheel FILE] [--wheels DIR] [--models DIR]
#   install.sh --rollback
#
# FILE: of RF-NAV, the newest in DIR unless told. DIR: wheels of all that it needs, as scripts/bundle
# puts them into `wheels` beside this script; nothing else is installed. `--models`: what `rfnav
# models pull` would fetch, `models` beside this script unless told.
#
# Versions lie side by side in /opt/rf-nav, with links to the current and the previous one, to which
# --rollback goes back. /etc/rf-nav is written once and never again; /var/lib/rf-nav is the
# service's. Run again it changes nothing that is right. Exit status: 0 done, 1 installed, but it
# does not start, 2 not installed: what ran goes on.
set -euo pipefail
umask 022
opt=/opt/rf-nav etc=/etc/rf-nav var=/var/lib/rf-nav
units=/usr/local/lib/systemd/system command=/usr/local/bin/rfnav
here=$(dirname "$(readlink -f "$0")")
say() { printf 'install: %s\n' "$*" >&2; }
fail() { say "$*"; exit 2; }

wheel="" wheels="$here/wheels" models="$here/models" rollback=""
while (($#)); do
  case "$1" in
    --rollback) rollback=yes; shift; continue ;;
    --wheel | --wheels | --models) (($# > 1)) || fail "$1: say which" ;;
    *) fail "$1: unknown; it takes --wheel FILE, --wheels DIR, --models DIR, or --rollback" ;;
  esac
  declare "${1#--}=$2"
  shift 2
done

# What stands in the way, all of it, a line each.
needed() {
  local wrong=0 tag
  trouble() { say "$*"; wrong=1; }
  [ "$(id -u)" = 0 ] || trouble "only root may install: sudo $0"
  [ -d /run/systemd/system ] || trouble "systemd does not run here: it is what the service is for"
  [ -z "$rollback" ] || return "$wrong"
  [ -f "$wheel" ] || trouble "${wheel:-$wheels/rf_nav-*.whl}: no wheel; scripts/bundle makes one"
  tag=$(python3 -c 'import sys; print("cp%d%d" % sys.version_info[:2])' 2>/dev/null || true)
  if ! python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
    trouble "python3 is missing or older than 3.11: apt-get install python3"
  elif ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
    trouble "Python cannot make environments: apt-get install python3-venv"
  elif [ -f "$wheel" ] && ! compgen -G "$wheels/numpy-*-$tag-*_$(uname -m).whl" >/dev/null; then
    trouble "$wheels: is not for $tag on $(uname -m): run scripts/bundle where these are"
  fi
  # No pipe: `grep -q` would end before a long list does, which pipefail takes for a failure.
  [[ "$(ldconfig -p)" == *"libgomp.so.1 "* ]] || trouble "libgomp.so.1 is missing: apt-get install libgomp1"
  return "$wrong"
}

# The environment of a version, whole or not there at all.
build() {
  local place=$1 pip log
  [ -e "$place/complete" ] && "$place/bin/rfnav" --help >/dev/null 2>&1 && return
  rm -rf "$place"
  log=$(mktemp)
  # As they are called now:
  # shellcheck disable=SC2064
  trap "rm -rf '$place' '$log'" EXIT
  python3 -m venv "$place"
  pip=("$place/bin/python" -m pip --disable-pip-version-check --no-input --quiet)
  "${pip[@]}" install --no-compile --no-index --find-links "$wheels" "$wheel[robot]" >"$log" 2>&1 ||
    fail "$(basename "$wheel"): not installed: $(grep -i error "$log" | tail -1)"
  "$place/bin/python" -m compileall -q -j 0 "$place/lib" >/dev/null || true # what is for other Pythons fails
  touch "$place/complete"
  trap - EXIT
  rm -f "$log"
}

as_service() { # a command with the service's user and places
  setpriv --reuid rf-nav --regid rf-nav --init-groups --no-new-privs env -i PATH="$PATH" HOME=$var \
    XDG_STATE_HOME=/var/lib XDG_DATA_HOME=/var/lib XDG_CACHE_HOME=/var/lib "$@"
}

# The user, the folders, the configuration unless it is there, the models.
furnish() {
  local place=$1
  systemd-sysusers "$place/share/rf-nav/systemd/rf-nav.sysusers" 2>/dev/null
  install -d -m 0755 "$etc"
  install -d -m 0700 -o rf-nav -g rf-nav "$var"
  [ -e "$etc/robot.toml" ] ||
    install -m 0640 -g rf-nav "$place/share/rf-nav/robot.toml" "$etc/robot.toml"
  if [ -d "$models" ]; then
    install -d -m 0700 -o rf-nav -g rf-nav "$var/models"
    cp -rn "$models/." "$var/models/"
    chown -R rf-nav:rf-nav "$var/models"
    chmod -R go= "$var/models" # as the service itself would leave them
  fi
  as_service "$place/bin/rfnav" models pull >/dev/null 2>"$place/said" ||
    fail "models: $(tail -1 "$place/said"); bring them with --models, or try again with a network"
  rm -f "$place/said"
}

# Makes a version the one that runs, or will; it is started anew where one ran.
switch() {
  local name=$1 before state
  before=$(readlink "$opt/current" || true)
  state=$(systemctl is-active rf-nav.service || true)
  [ -z "$before" ] || [ "$before" = "$name" ] || ln -sfn "$before" "$opt/previous"
  ln -sfn "$name" "$opt/current"
  ln -sfn "$opt/current/bin/rfnav" "$command"
  install -d "$units"
  rm -f "$units"/rf-nav*.service
  install -m 0644 "$opt/$name"/share/rf-nav/systemd/*.service "$units"
  systemctl daemon-reload
  systemctl enable --quiet rf-nav.service
  as_service "$opt/current/bin/rfnav" check --config "$etc/robot.toml" >/dev/null ||
    say "correct that in $etc/robot.toml; until then it does not start"
  if [ "$state" = inactive ]; then
    say "$name is installed; when $etc/robot.toml is your robot's: systemctl start rf-nav"
    return
  elif [ "$state $before" = "active $name" ]; then
    say "$name is there already, and runs"
    return
  fi
  systemctl reset-failed rf-nav.service 2>/dev/null || true
  if systemctl restart rf-nav-guard.service rf-nav.service; then
    say "$name runs; back to the version before: $opt/current/share/rf-nav/install.sh --rollback"
  else
    say "$name does not start: journalctl -u rf-nav says why; back: $opt/current/share/rf-nav/install.sh --rollback"
    exit 1
  fi
}

main() {
  local name previous
  [ -n "$wheel" ] || wheel=$(compgen -G "$wheels/rf_nav-*.whl" | sort -V | tail -1 || true)
  needed || exit 2
  if [ -n "$rollback" ]; then
    previous=$(readlink "$opt/previous" || true)
    [ -n "$previous" ] || fail "there is no version before"
    switch "$previous"
    return
  fi
  name=$(basename "$wheel" | cut -d- -f2)-$({ cat "$wheel"; ls "$wheels"; } | sha256sum | cut -c1-8)
  install -d "$opt"
  build "$opt/$name"
  furnish "$opt/$name"
  switch "$name"
  for place in "$opt"/*/; do
    case "$(basename "$place")" in
      current | previous | "$(readlink "$opt/current")" | "$(readlink "$opt/previous" || true)") ;;
      *) rm -rf "$place" ;;
    esac
  done
}

main
exit
