# shellcheck shell=bash disable=SC2154
# Sourced by the benchmarks that need a server, after `preset` is set. A folder "$work" and whatever runs are gone when the
# script ends; the store outlives a server that is stopped and started again.

bin=build/$preset/bin
work=$(mktemp -d)
server_pid=
address=

start_server() {  # configuration
  : >"$work/server.out"
  "$bin/semmapd" --config "$1" --data "$work/store" --listen 127.0.0.1:0 >"$work/server.out" 2>>"$work/server.log" &
  server_pid=$!
  for _ in $(seq 100); do
    address=$(sed -n 's/^listening on //p' "$work/server.out")
    [[ -n $address ]] && return
    sleep 0.1
  done
  echo "the server did not start" >&2
  cat "$work/server.log" >&2
  exit 1
}

stop_server() {
  [[ -z $server_pid ]] || { kill "$server_pid" && wait "$server_pid"; } 2>/dev/null || true
  server_pid=
}

trap 'stop_server; rm -rf "$work"' EXIT

# A drive through the town at ten frames a second, unless the folder has it already.
draw() {  # folder, then arguments of the drive
  local folder=$1
  shift
  [[ -f $folder/times.txt ]] && return
  printf 'frames_per_second: 10\n' >"$work/rig.yaml"
  "$bin/semmap" town drive --seed 1 --grey --no-class --no-depth --rig "$work/rig.yaml" --output "$folder" "$@" >&2
}
