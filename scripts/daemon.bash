# Sourced by the scripts that need a tissued of their own: on free ports, and gone with the script.
# The caller sets -euo pipefail and has built the release preset.
bin=build/release/daemon
logs=$(mktemp -d)
daemon=
tracker=  # HOST:PORT, where it listens for its tracker
clients=  # HOST:PORT, where it answers

stop_daemon() {
  [ -n "$daemon" ] || return 0
  kill "$daemon" 2>/dev/null || true
  wait "$daemon" 2>/dev/null || true
  daemon=
}
trap 'stop_daemon; rm -rf "$logs"' EXIT

# start_daemon ARGUMENTS OF tissued...
start_daemon() {
  : >"$logs/ports"
  "$bin/tissued" "$@" --tracker-port 0 --client-port 0 >"$logs/ports" 2>"$logs/errors" &
  daemon=$!
  until grep -q listening "$logs/ports"; do
    kill -0 "$daemon" 2>/dev/null || { cat "$logs/errors" >&2; exit 1; }
    sleep 0.05
  done
  tracker=127.0.0.1:$(sed -n 's/.*tracker=\([0-9]*\).*/\1/p' "$logs/ports")
  clients=127.0.0.1:$(sed -n 's/.*clients=\([0-9]*\).*/\1/p' "$logs/ports")
}
