#!/bin/bash
# UNTESTED. The report's page embeds three.js, for which no conda package is known:
# KINEGRAPH_THREE_JS is a folder of its release r111 with three.min.js and
# examples/js/controls/OrbitControls.js.
set -euo pipefail
cmake -S . -B build/conda -G Ninja ${CMAKE_ARGS:-} \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$PREFIX" \
  -DKINEGRAPH_TESTS=OFF -DPython3_EXECUTABLE="$PYTHON" \
  -DKINEGRAPH_THREE_JS="${KINEGRAPH_THREE_JS:?folder of three.js r111}" \
  -DKINEGRAPH_PYTHON_FOLDER="${SP_DIR#"$PREFIX"/}"
cmake --build build/conda --parallel "${CPU_COUNT:-2}"
cmake --install build/conda
