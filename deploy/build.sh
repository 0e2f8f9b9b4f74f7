#!/usr/bin/env bash
# Sets up and builds one preset: deploy/build.sh [PRESET] [TARGET...]. Takes seconds when nothing changed.
set -euo pipefail
cd "$(dirname "$0")/.."

preset=${1:-release}
shift || true
deploy/install-deps.sh
if [[ ! -f build/$preset/build.ninja ]]; then
  cmake --preset "$preset" >"/tmp/semmap-configure-$preset.log" 2>&1 || { cat "/tmp/semmap-configure-$preset.log"; exit 1; }
fi
cmake --build --preset "$preset" ${1:+--target "$@"}
