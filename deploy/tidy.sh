#!/usr/bin/env bash
# Runs clang-tidy over the sources: deploy/tidy.sh [REGEX...], where a REGEX chooses files by path ("slam/", "feature_codec").
# Reads them without precompiled headers, so that a missing include is an error. The whole tree takes an hour of processor
# time, most of it in what includes gRPC.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v run-clang-tidy >/dev/null; then
  echo "clang-tidy is not installed: apt-get install clang-tidy" >&2
  exit 2
fi
deploy/install-deps.sh
cmake --preset release -B build/tidy -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >/dev/null
cmake --build build/tidy --target semmap_generated >/dev/null
# Generated files are not ours to tidy.
chosen=("$@")
((${#chosen[@]})) || chosen=(slam/ storage/ server/ client/ tests/)
patterns=()
for pattern in "${chosen[@]}"; do patterns+=("^$PWD/(?!build/).*$pattern"); done
nice run-clang-tidy -quiet -p build/tidy -j "${TIDY_JOBS:-$(nproc)}" "${patterns[@]}"
