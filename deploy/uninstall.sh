#!/usr/bin/env bash
# Takes RF-NAV off this computer. Configuration and what it has learnt stay, unless --purge: then
# nothing of it is left, its user, its credentials and your changes to its units included.
#
#   uninstall.sh [--purge]
set -euo pipefail
say() { printf 'uninstall: %s\n' "$*" >&2; }

main() {
  local purge="" units=/usr/local/lib/systemd/system
  case "${1-}" in
    "") ;;
    --purge) purge=yes ;;
    *) say "$1: unknown; it takes --purge"; exit 2 ;;
  esac
  [ "$(id -u)" = 0 ] || { say "only root may: sudo $0"; exit 2; }
  systemctl disable --quiet --now rf-nav.service 2>/dev/null || true
  systemctl stop --quiet rf-nav-again.service rf-nav-guard.service 2>/dev/null || true
  rm -f "$units"/rf-nav.service "$units"/rf-nav-guard.service "$units"/rf-nav-again.service
  rmdir --ignore-fail-on-non-empty "$units" "${units%/*}" 2>/dev/null || true
  rm -f /usr/local/bin/rfnav
  rm -rf /opt/rf-nav
  if [ -n "$purge" ]; then
    rm -rf /etc/rf-nav /var/lib/rf-nav /etc/systemd/system/rf-nav{,-guard,-again}.service.d
    rm -f /etc/credstore/rf-nav.*
    ! id rf-nav >/dev/null 2>&1 || userdel rf-nav
  fi
  systemctl daemon-reload
  systemctl reset-failed rf-nav.service rf-nav-guard.service rf-nav-again.service 2>/dev/null || true
  if [ -n "$purge" ]; then say "nothing is left"; else
    say "/etc/rf-nav and /var/lib/rf-nav are left; --purge removes them, too"
  fi
}

main "$@"
exit
