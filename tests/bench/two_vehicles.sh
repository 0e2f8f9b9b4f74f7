#!/usr/bin/env bash
# Two vehicles drive overlapping parts of the town's route `loop` at once and extend one map, each among traffic of its
# own: tests/bench/two_vehicles.sh --town DIR [--sensor stereo|mono] [--preset NAME] [--overlap FRAMES]
# DIR holds the drives; those that are missing are drawn first (ten minutes on a quiet machine). The map begins with the
# first seconds of the first drive. One vehicle goes on from there; the other begins where nobody has been, maps a piece
# of its own, and is joined to the map at the place that both have seen. Prints how well the one map fits the truth, and
# itself where the two meet.
set -euo pipefail
cd "$(dirname "$0")/../.."

town=
preset=release
overlap=200
sensor=stereo
while (($#)); do
  case $1 in
    --town) town=$2; shift 2 ;;
    --preset) preset=$2; shift 2 ;;
    --sensor) sensor=$2; shift 2 ;;
    --overlap) overlap=$2; shift 2 ;;
    *) echo "unknown argument $1" >&2; exit 2 ;;
  esac
done
[[ -n $town ]] || { echo "--town DIR is missing" >&2; exit 2; }

. tests/bench/with_server.sh

# One camera needs more of a drive until there is a map.
case $sensor in
  stereo) eyes=(0 1) drawn_with=(--stereo) drive_name=loop seed_frames=30 ;;
  mono) eyes=(0) drawn_with=() drive_name=loop_mono seed_frames=80 ;;
  *) echo "unknown sensor $sensor" >&2; exit 2 ;;
esac
one=$town/${drive_name}_21
other=$town/${drive_name}_22

part() {  # source target first last
  mkdir -p "$2"
  cp "$1/calib.txt" "$2/"
  sed -n "$(($3 + 1)),$(($4 + 1))p" "$1/times.txt" >"$2/times.txt"
  sed -n "$(($3 + 1)),$(($4 + 1))p" "$1/poses_town.txt" >"$2/poses.txt"
  local i side
  for side in "${eyes[@]}"; do
    mkdir "$2/image_$side"
    for ((i = $3; i <= $4; ++i)); do
      ln -s "$(realpath "$1/image_$side/$(printf '%06d.png' "$i")")" "$2/image_$side/$(printf '%06d.png' $((i - $3)))"
    done
  done
}

drive() {  # part mode vehicle
  "$bin/semmap" drive --server "$address" --source "kitti:$work/$1" --sensor "$sensor" --mode "$2" --map town --vehicle "$3" \
    --trajectory "$work/$3.txt" --format tum --json >"$work/$3.json"
}

# The frame of the second drive that was taken nearest to where a frame of the first one was.
same_place() {  # line of the first truth, second truth
  awk -v here="$1" 'BEGIN { split(here, h) }
    { d = ($4 - h[4])^2 + ($8 - h[8])^2 + ($12 - h[12])^2; if (NR == 1 || d < least) { least = d; at = NR - 1 } }
    END { print at }' "$2"
}

draw "$one" --route loop "${drawn_with[@]}" --traffic-seed 21
draw "$other" --route loop "${drawn_with[@]}" --traffic-seed 22
last=$(($(wc -l <"$one/times.txt") - 1))
middle=$((last / 2))
begin=$(same_place "$(sed -n "$((middle - overlap / 2 + 1))p" "$one/poses_town.txt")" "$other/poses_town.txt")
# A little short of the start, where the map begins: the two meet in the middle alone.
end=$(($(wc -l <"$other/times.txt") - 60))
part "$one" "$work/seed" 0 "$seed_frames"
part "$one" "$work/first" $((seed_frames + 1)) $((middle + overlap / 2))
part "$other" "$work/second" "$begin" "$end"

start_server config/semmapd.yaml
drive seed map seed
drive first extend first &
first=$!
drive second extend second
wait "$first"
grep -o 'own piece .*' "$work/server.log" || true
"$bin/semmap" map check town --server "$address"
"$bin/semmap" maps --server "$address"
with_scale=()
[[ $sensor == mono ]] && with_scale=(--with-scale)
"$bin/map_seam" "${with_scale[@]}" --first "$work/first.txt" --first-truth "$work/first/poses.txt" --first-times "$work/first/times.txt" \
  --second "$work/second.txt" --second-truth "$work/second/poses.txt" --second-times "$work/second/times.txt"
