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

step "two vehicles drive the simulated town at once, $frames frames each, and stream what they see"
drive() {  # name route
  "$bin/semmap" town drive --server "$address" --seed 1 --route "$2" --vehicles 20 --pedestrians 10 --frames "$frames" --stereo --send-class \
    --map "town-$1" --vehicle "$1" --trajectory "$out/$1.txt" --truth "$out/$1.truth.txt" >"$out/$1.drive" 2>"$out/$1.progress"
}
drive red 2 & red=$!
drive blue 3 & blue=$!
wait $red || { cat "$out/red.progress"; exit 1; }
wait $blue || { cat "$out/blue.progress"; exit 1; }
cat "$out/red.drive" "$out/blue.drive"

step "their poses against the truth, which never left the vehicles"
for name in red blue; do
  echo "$name:"
  "$bin/semmap" eval ate --reference "$out/$name.truth.txt" --reference-format tum \
    --estimate "$out/$name.txt" --format tum --align se3 --plot "$out/$name.png"
done

step "the maps in the database"
"$bin/semmap" maps --server "$address"
"$bin/semmap" map show town-red --server "$address"

step "pictures"
for name in red blue; do
  "$bin/semmap" picture "town-$name" --server "$address" --output "$out/town-$name.png"
done
"$bin/semmap" town map --seed 1 --output "$out/town.png" >/dev/null
echo "$out/town-red.png and $out/town-blue.png: the maps, points by class; $out/red.png and $out/blue.png: trajectory and error;"
echo "$out/town.png: the town from above"
