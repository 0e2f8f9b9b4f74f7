#!/usr/bin/env bash
# Relocalization in stored maps, through the service: a map of one drive, pictures of others.
#   tests/bench/map_relocalization.sh [--town DIR] [--preset NAME] [--config FILE] [--every N]
# Real frames: the even frames of kitti00_mono200 make a map, the odd ones are looked for in it. Town (with --town): DIR holds the
# drives, and those that are missing are drawn first (ten minutes on a quiet machine): a map of route 2 at noon; other traffic at noon,
# under an overcast sky, at dusk and in the opposite direction; and route 3, which is elsewhere but for its ends. Each is asked
# picture by picture and driven through a LOCALIZE session; dusk also in a map of noon to which the overcast drive was added. The
# server is restarted between two runs of the first, whose answers must not differ by more than 1e-9. Every answer that is wrong by
# over 5 m counts as a failure of this script.
set -euo pipefail
cd "$(dirname "$0")/../.."

town=
preset=release
config=config/semmapd.yaml
every=2
while (($#)); do
  case $1 in
    --town) town=$2; shift 2 ;;
    --preset) preset=$2; shift 2 ;;
    --config) config=$2; shift 2 ;;
    --every) every=$2; shift 2 ;;
    *) echo "unknown argument $1" >&2; exit 2 ;;
  esac
done

. tests/bench/with_server.sh
data=${SEMMAP_SHARED:-../shared}/data/sequences

make_map() {  # name source sensor
  "$bin/semmap" drive --server "$address" --source "kitti:$2" --sensor "$3" --mode map --map "$1" --vehicle mapper --json \
    >"$work/$1.drive.json"
}

failures=0
queries=0
elsewhere=0
ask() {  # label, then arguments of the benchmark
  local label=$1
  shift
  "$bin/map_relocalization" --server "$address" "$@" >"$work/table"
  if [[ -z ${heading_printed:-} ]]; then
    printf '%-28s %s\n' queries "$(sed -n 1p "$work/table")"
    heading_printed=1
  fi
  printf '%-28s %s\n' "$label" "$(sed -n 2p "$work/table")"
  sed -n '3,$p' "$work/table"
  local of_row
  read -ra of_row < <(sed -n 2p "$work/table")
  ((queries += of_row[0])) || true
  ((elsewhere += ${of_row[7]#*/})) || true
  ((failures += of_row[8])) || true
}

every_other() {  # source target first
  mkdir -p "$2/image_0"
  cp "$1/calib.txt" "$2/"
  awk -v f="$3" '(NR - 1) % 2 == f' "$1/times.txt" >"$2/times.txt"
  awk -v f="$3" '(NR - 1) % 2 == f' "$1/poses.txt" >"$2/poses.txt"
  local i=0 image
  for image in "$1"/image_0/*; do
    ((i++ % 2 == $3)) && ln -s "$(realpath "$image")" "$2/image_0/"
  done
  return 0
}

start_server "$config"
if [[ -d $data/kitti00_mono200 ]]; then
  every_other "$data/kitti00_mono200" "$work/even" 0
  every_other "$data/kitti00_mono200" "$work/odd" 1
  make_map kitti "$work/even" mono
  kitti=(--map kitti --map-times "$work/even/times.txt" --map-truth "$work/even/poses.txt" --query "kitti:$work/odd"
    --query-truth "$work/odd/poses.txt" --with-scale)
  ask "kitti00, odd frames" "${kitti[@]}" --answers "$work/before.json"
  stop_server
  start_server "$config"
  ask "after a restart" "${kitti[@]}" --compare "$work/before.json"
fi
if [[ -n $town ]]; then
  traffic=(--vehicles 20 --pedestrians 10)
  draw "$town/map_r2" --route 2 "${traffic[@]}" --traffic-seed 1 --stereo --weather noon
  draw "$town/q_noon" --route 2 "${traffic[@]}" --traffic-seed 7 --stereo --weather noon
  draw "$town/q_else" --route 3 "${traffic[@]}" --traffic-seed 9 --weather noon
  draw "$town/q_overcast" --route 2 "${traffic[@]}" --traffic-seed 8 --stereo --weather overcast
  draw "$town/q_dusk" --route 2 "${traffic[@]}" --traffic-seed 10 --weather dusk
  draw "$town/q_back" --route 2-back "${traffic[@]}" --traffic-seed 11 --weather noon
  make_map town "$town/map_r2" stereo
  truth=(--map-times "$town/map_r2/times.txt" --map-truth "$town/map_r2/poses_town.txt")
  of() { echo --query "kitti:$town/q_$1" --query-truth "$town/q_$1/poses_town.txt"; }
  for query in noon overcast dusk else back; do
    heading=()
    [[ $query == back ]] && heading=(--any-heading)
    # shellcheck disable=SC2046  # words on purpose
    ask "$query, pictures" --map town "${truth[@]}" $(of $query) --every "$every" "${heading[@]}"
  done
  # shellcheck disable=SC2046
  ask "noon, stereo pictures" --map town "${truth[@]}" $(of noon) --every "$every" --sensor stereo
  echo "$queries questions in all, $elsewhere of them from elsewhere, $failures answers wrong by over 5 m"
  for query in noon overcast dusk back; do
    heading=()
    [[ $query == back ]] && heading=(--any-heading)
    # shellcheck disable=SC2046
    ask "$query, drive" --map town "${truth[@]}" $(of $query) --drive "${heading[@]}"
  done
  # shellcheck disable=SC2046
  ask "noon, stereo drive" --map town "${truth[@]}" $(of noon) --drive --sensor stereo
  "$bin/semmap" map copy town both --server "$address" >/dev/null
  "$bin/semmap" drive --server "$address" --source "kitti:$town/q_overcast" --sensor stereo --mode extend --map both \
    --vehicle mapper --json >"$work/both.drive.json"
  # shellcheck disable=SC2046
  ask "dusk, in noon and overcast" --map both "${truth[@]}" $(of dusk) --every "$every"
  # shellcheck disable=SC2046
  ask "dusk, drive in both" --map both "${truth[@]}" $(of dusk) --drive
fi
((failures == 0))
