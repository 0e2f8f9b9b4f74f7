#!/usr/bin/env bash
# Sets everything up and runs all tests: deploy/test.sh [PRESET] [ctest arguments...].
# Presets: release (default), dev, asan, tsan. Tests that need recorded sequences look for them in $SEMMAP_SHARED or in
# ../shared and skip where they are absent.
set -euo pipefail
cd "$(dirname "$0")/.."

preset=${1:-release}
shift || true
deploy/build.sh "$preset"
# Files of the tests stay in this tree, so that two trees can be tested at once.
export TEST_TMPDIR="$PWD/build/$preset/test-files/"
mkdir -p "$TEST_TMPDIR"
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:strict_string_checks=1}
export TSAN_OPTIONS=${TSAN_OPTIONS:-suppressions=$PWD/tests/tsan.supp:history_size=4}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
ctest --test-dir "build/$preset" --output-on-failure --parallel "$(nproc)" "$@"
