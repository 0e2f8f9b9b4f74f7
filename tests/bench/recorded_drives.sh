#!/usr/bin/env bash
# Drives the recorded sequences through a server over gRPC and prints accuracy and speed as a table:
#   tests/bench/recorded_drives.sh [--runs N] [--together] [--config FILE] [--preset NAME]
# N runs each (default 3), medians last. --together: all sequences at once into one server, as a fleet would. The data is
# looked for in $SEMMAP_SHARED or ../shared.
set -euo pipefail
cd "$(dirname "$0")/../.."

runs=3
together=0
config=config/semmapd.yaml
preset=release
while (($#)); do
  case $1 in
    --runs) runs=$2; shift 2 ;;
    --together) together=1; shift ;;
    --config) config=$2; shift 2 ;;
    --preset) preset=$2; shift 2 ;;
    *) echo "unknown argument $1" >&2; exit 2 ;;
  esac
done

data=${SEMMAP_SHARED:-../shared}/data/sequences
if [[ ! -d $data ]]; then
  echo "no recorded sequences at $data: nothing to drive" >&2
  exit 0
fi
. tests/bench/with_server.sh
start_server "$config"

# name  source  sensor  alignment  reference format  reference
sequences=(
  "kitti06_stereo51 kitti stereo se3 kitti poses.txt"
  "kitti06_stereo51 kitti mono sim3 kitti poses.txt"
  "kitti00_mono200 kitti mono sim3 kitti poses.txt"
  "rgbd_kitchen200 tum rgbd se3 tum groundtruth.txt"
)

drive() {  # run name source sensor
  "$bin/semmap" drive --server "$address" --source "$3:$data/$2" --sensor "$4" --mode map --map "$2-$4-$1" \
    --vehicle "car-$2-$4" --trajectory "$work/$2-$4-$1.txt" --format tum --json >"$work/$2-$4-$1.drive.json"
}

field() { sed -n "s/.*\"$2\": *\\([-0-9.e+]*\\).*/\\1/p" "$1" | head -n 1; }

report() {  # run name sensor align format reference
  local times=()
  [[ $5 == kitti ]] && times=(--reference-times "$data/$2/times.txt")
  "$bin/semmap" eval ate --reference "$data/$2/$6" --reference-format "$5" "${times[@]}" \
    --estimate "$work/$2-$3-$1.txt" --format tum --align "$4" --json >"$work/$2-$3-$1.eval.json"
  local drive_json=$work/$2-$3-$1.drive.json
  printf '%-18s %-7s %4s %8s %8s %9.4f %10.1f %10.1f\n' "$2" "$3" "$1" "$(field "$drive_json" frames)" \
    "$(field "$drive_json" tracked)" "$(field "$work/$2-$3-$1.eval.json" rmse)" "$(field "$drive_json" median_ms)" \
    "$(field "$drive_json" p95_ms)"
}

printf '%-18s %-7s %4s %8s %8s %9s %10s %10s\n' sequence sensor run frames tracked "ATE m" "median ms" "p95 ms"
for run in $(seq "$runs"); do
  jobs=()
  for entry in "${sequences[@]}"; do
    read -r name source sensor _ <<<"$entry"
    if ((together)); then
      drive "$run" "$name" "$source" "$sensor" &
      jobs+=($!)
    else
      drive "$run" "$name" "$source" "$sensor"
    fi
  done
  for job in "${jobs[@]}"; do wait "$job"; done
  for entry in "${sequences[@]}"; do
    read -r name source sensor align format reference <<<"$entry"
    report "$run" "$name" "$sensor" "$align" "$format" "$reference" | tee -a "$work/rows"
  done
done
echo
echo "medians over $runs runs"
for entry in "${sequences[@]}"; do
  read -r name _ sensor _ <<<"$entry"
  for column in 5 6 7 8; do
    awk -v n="$name" -v s="$sensor" -v c=$column '$1 == n && $2 == s {print $c}' "$work/rows" | sort -n |
      awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'
  done | paste -sd' ' | awk -v n="$name" -v s="$sensor" '{printf "%-18s %-7s tracked %s  ATE %s m  median %s ms  p95 %s ms\n", n, s, $1, $2, $3, $4}'
done
