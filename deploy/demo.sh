#!/usr/bin/env bash
# The main job, from nothing: sets up and builds, starts a server on SQLite, lets two vehicles drive the simulated town at
# once, compares their poses with the truth, and shows what the database holds now. Results stay in build/demo.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/build.sh release semmapd semmap
bin=build/release/bin
out=build/demo
frames=${DEMO_FRAMES:-120}
rm -rf "$out/store" && mkdir -p "$out"

step() { printf '\n== %s\n' "$*"; }

step "two vehicles of the town (each $frames frames; kept in $out for the next time)"
record() {  # name route
  if [[ ! -f $out/$1-$frames/poses.txt ]]; then
    "$bin/semmap" town drive --seed 1 --route "$2" --vehicles 20 --pedestrians 10 --frames "$frames" --stereo --no-class --no-depth \
      --output "$out/$1-$frames.part" >"$out/$1.log" 2>&1 || { cat "$out/$1.log"; exit 1; }
    rm -rf "$out/$1-$frames" && mv "$out/$1-$frames.part" "$out/$1-$frames"
  fi
}
record red 2
record blue 3
"$bin/semmap" town map --seed 1 --output "$out/town.png" >/dev/null

step "a server"
"$bin/semmapd" --config config/semmapd.yaml --data "$out/store" --listen 127.0.0.1:0 >"$out/server.out" 2>"$out/server.log" &
server=$!
trap 'kill $server 2>/dev/null; wait $server 2>/dev/null || true' EXIT
for _ in $(seq 100); do
  address=$(sed -n 's/^listening on //p' "$out/server.out")
  [[ -n $address ]] && break
  sleep 0.1
done
[[ -n ${address:-} ]] || { cat "$out/server.log"; exit 1; }
echo "semmapd listens on $address, its database is in $out/store"

step "both drive at once"
drive() {  # name
  "$bin/semmap" drive --server "$address" --source "kitti:$out/$1-$frames" --sensor stereo --mode map --map "town-$1" \
    --vehicle "$1" --trajectory "$out/$1.txt" --format tum >"$out/$1.drive" 2>"$out/$1.progress"
}
drive red & red=$!
drive blue & blue=$!
wait $red || { cat "$out/red.progress"; exit 1; }
wait $blue || { cat "$out/blue.progress"; exit 1; }
cat "$out/red.drive" "$out/blue.drive"

step "their poses against the truth"
for name in red blue; do
  echo "$name:"
  "$bin/semmap" eval ate --reference "$out/$name-$frames/poses.txt" --reference-format kitti \
    --reference-times "$out/$name-$frames/times.txt" --estimate "$out/$name.txt" --format tum --align se3 \
    --plot "$out/$name.png"
done

step "the maps in the database"
"$bin/semmap" maps --server "$address"
"$bin/semmap" map show town-red --server "$address"

step "pictures"
echo "$out/red.png and $out/blue.png: trajectory and error; $out/town.png: the town from above"
