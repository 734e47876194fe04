#!/bin/bash
# Builds the wheel: commands, module and the libraries that they link. It requires
# only NumPy and system libraries as new as Debian 12's: those of C (glibc 2.36) and
# C++, and zlib.
#
#   packaging/wheel.sh [FOLDER]     default: out/wheel, for the python3 in PATH
#
# Needs what `./kinegraph build` needs, and patchelf. KINEGRAPH_BUILD: the build
# folder, possibly an existing one that includes the module; default build/wheel.
set -euo pipefail
root=$(cd -P "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
out=${1:-$root/out/wheel}
build=${KINEGRAPH_BUILD:-$root/build/wheel}

for need in patchelf gcc strip:binutils readelf:binutils dpkg-query:dpkg; do
  command -v "${need%:*}" >/dev/null || {
    echo "wheel.sh: error: needs ${need%:*} (apt-get install ${need#*:})" >&2
    exit 1
  }
done
if [[ ! -e $build/build.ninja ]]; then
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DKINEGRAPH_TESTS=OFF -DKINEGRAPH_UNITY=ON \
    -DCMAKE_CXX_FLAGS="-ffunction-sections -fdata-sections" \
    -DCMAKE_EXE_LINKER_FLAGS=-Wl,--gc-sections \
    -DCMAKE_MODULE_LINKER_FLAGS=-Wl,--gc-sections
fi
cmake --build "$build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" \
  --target kinegraph_commands
mkdir -p "$out"
python3 "$root/packaging/make_wheel.py" "$build" "$out"
