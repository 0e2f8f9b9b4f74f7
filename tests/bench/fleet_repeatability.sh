#!/usr/bin/env bash
# Shows that vehicles do not disturb each other: drives the recorded sequences one by one and then all at once into one
# server, in the one-thread configuration, and compares the trajectories byte for byte; restarts the server and asks for
# every map again. Needs the recorded sequences ($SEMMAP_SHARED or ../shared): tests/bench/fleet_repeatability.sh [PRESET]
set -euo pipefail
cd "$(dirname "$0")/../.."

preset=${1:-release}
data=${SEMMAP_SHARED:-../shared}/data/sequences
if [[ ! -d $data ]]; then
  echo "no recorded sequences at $data: nothing to drive" >&2
  exit 0
fi
. tests/bench/with_server.sh

drive() {  # prefix name source sensor
  "$bin/semmap" drive --server "$address" --source "$3:$data/$2" --sensor "$4" --mode map --map "$1-$2-$4" --vehicle "$2-$4" \
    --trajectory "$work/$1-$2-$4.txt" --format tum --json >/dev/null 2>"$work/$1-$2-$4.err"
}

drives=("kitti06_stereo51 kitti stereo" "kitti06_stereo51 kitti mono" "kitti00_mono200 kitti mono" "rgbd_kitchen200 tum rgbd")
start_server config/semmapd-deterministic.yaml
for entry in "${drives[@]}"; do
  read -ra words <<<"$entry"
  drive alone "${words[@]}"
done
jobs=()
for entry in "${drives[@]}"; do
  read -ra words <<<"$entry"
  drive together "${words[@]}" &
  jobs+=($!)
done
for job in "${jobs[@]}"; do wait "$job"; done
stop_server
start_server config/semmapd-deterministic.yaml
"$bin/semmap" maps --server "$address"

failed=0
for entry in "${drives[@]}"; do
  read -r name _ sensor <<<"$entry"
  map=together-$name-$sensor
  same=differ
  cmp -s "$work/alone-$name-$sensor.txt" "$work/$map.txt" && same="equal byte for byte"
  "$bin/semmap" trajectory --server "$address" --map "$map" >"$work/again.txt"
  points=$("$bin/semmap" points --server "$address" --map "$map" --limit 0 2>/dev/null | tail -n +2 | wc -l)
  keyframes=$("$bin/semmap" keyframes --server "$address" --map "$map" --limit 0 2>/dev/null | tail -n +2 | wc -l)
  poses=$(grep -vc '^#' "$work/again.txt")
  printf '%-18s %-7s alone and together: %s; after a restart: %s poses, %s keyframes, %s points\n' "$name" "$sensor" "$same" \
    "$poses" "$keyframes" "$points"
  [[ $same == differ || $poses == 0 || $points == 0 || $keyframes == 0 ]] && failed=1
done
exit $failed
