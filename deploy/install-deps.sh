#!/usr/bin/env bash
# Installs what semmap needs to build, test and run, from Debian 12's own packages, and only what is missing.
set -euo pipefail

packages=(
  # build
  build-essential cmake ninja-build ccache git pkg-config protobuf-compiler protobuf-compiler-grpc
  # libraries
  libopencv-dev libeigen3-dev libceres-dev libabsl-dev libprotobuf-dev libgrpc++-dev libgrpc-dev libsqlite3-dev
  libyaml-cpp-dev libspdlog-dev libcli11-dev nlohmann-json3-dev libjpeg-dev libxxhash-dev
  libtorch-dev libssl-dev libgeographiclib-dev
  # the simulated town: off-screen OpenGL without a display
  libepoxy-dev libegl-dev libglm-dev libegl1 libegl-mesa0 libgl1-mesa-dri
  # tests
  libgtest-dev libgmock-dev libbenchmark-dev libfaiss-dev
  python3 python3-grpcio python3-protobuf
)

missing=()
for package in "${packages[@]}"; do
  if ! dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed; then
    missing+=("$package")
  fi
done
if ((${#missing[@]} == 0)); then
  exit 0
fi

echo "installing: ${missing[*]}"
as_root=()
if ((EUID != 0)); then
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
