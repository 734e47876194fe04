#!/bin/bash
# Checks of .ci/run other than the tests: tests/checks.sh CHECK BUILD
#   tidy     clang-tidy on core, solvers and apps; any finding in a line that
#            changed since KINEGRAPH_CI_BASE (default: the commit before this
#            one) is an error
#   single   compiles every source of solvers, commands and the Python module
#            separately, without unity builds (the sanitizers compile core in
#            this way)
#   corpora  replays the inputs on which a reader once failed, and fuzzes each
#            reader briefly with libFuzzer
#   readers  tests of core/io under Clang's address and undefined-behaviour
#            sanitizers
#   units    tests of the rest of core under these sanitizers, except those of
#            core/tracking and core/kinematics
# The last line states the result, or what is missing (exit code 77).
set -uo pipefail
# In an empty environment bash sets PATH without exporting it; cmake needs it.
export PATH
root=$(cd -P "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
build=$(readlink -f "$2")
jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
cd "$root" || exit 1

skip() {
  echo "$1"
  exit 77
}

need() {  # PROGRAM...
  local program
  for program in "$@"; do
    command -v "$program" >/dev/null || skip "needs $program"
  done
}

# Sources of the library and the commands that changed or whose header changed.
changed_sources() {  # BASE
  git diff --name-only --diff-filter=d "$1" -- core solvers apps |
    sed -n 's/\.h$/.cc/p; /\.cc$/p' | sort -u |
    while read -r file; do if [[ -e $file ]]; then echo "$file"; fi; done
}

# Changed lines in the format of clang-tidy's --line-filter: findings in older
# lines are ignored.
changed_lines() {  # BASE
  git diff -U0 --diff-filter=d "$1" -- '*.cc' '*.h' | python3 -c '
import json, re, sys
lines = {}
for line in sys.stdin:
  if line.startswith("+++ "):
    at = lines.setdefault(line[6:].strip(), [])
  found = re.match(r"@@ .* \+(\d+)(?:,(\d+))? @@", line)
  if found:
    first, count = int(found[1]), int(found[2] or 1)
    if count: at.append([first, first + count - 1])
print(json.dumps([{"name": name, "lines": at} for name, at in lines.items() if at]))'
}

tidy() {
  need clang-tidy-14 git ninja python3
  local base=${KINEGRAPH_CI_BASE:-HEAD^} sources
  git rev-parse --quiet --verify "$base^{commit}" >/dev/null ||
    skip "there is no commit '$base' to compare with"
  mapfile -t sources < <(changed_sources "$base")
  if ((${#sources[@]} == 0)); then
    echo "no source of the library or the commands changed since $base"
    return
  fi
  local database=$build/single
  configure_single || return 1
  printf '%s\0' "${sources[@]}" |
    xargs -0 -n 1 -P "$jobs" clang-tidy-14 --quiet -p "$database" \
      --line-filter="$(changed_lines "$base")" \
      --extra-arg-before=-std=c++17 --warnings-as-errors='*' || return 1
  echo "${#sources[@]} sources, changed since $base"
}

# Compile commands of a build that compiles each source separately.
configure_single() {
  cmake -S . -B "$build/single" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_CXX_COMPILER=clang++-14 -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
    -DKINEGRAPH_WARNINGS_AS_ERRORS=ON -DKINEGRAPH_UNITY=OFF \
    -DKINEGRAPH_TESTS=OFF >"$build/single.log" 2>&1
}

single() {
  need clang++-14 ninja python3
  configure_single || return 1
  python3 - "$build/single/compile_commands.json" "$jobs" <<'PYTHON' || return 1
import concurrent.futures, json, os, shlex, subprocess, sys

root = os.getcwd()
own = tuple(f"{root}/{folder}/" for folder in ("apps", "python", "solvers"))
commands = [c for c in json.load(open(sys.argv[1])) if c["file"].startswith(own)]

def compiles(command):
    words = shlex.split(command["command"])
    at = words.index("-o")
    return subprocess.call(words[:at] + words[at + 2:] + ["-fsyntax-only"],
                           cwd=command["directory"]) == 0

with concurrent.futures.ThreadPoolExecutor(int(sys.argv[2])) as threads:
    if not all(list(threads.map(compiles, commands))):
        sys.exit(1)
print(len(commands), "sources")
PYTHON
}

configure_instrumented() {
  need clang-14 clang++-14 ninja
  # Clang without its runtime libraries cannot link such programs.
  local library
  library=$(clang++-14 -print-file-name=libclang_rt.fuzzer-x86_64.a)
  [[ $(uname -m) != x86_64 || -e $library ]] || skip "needs libclang-rt-14-dev"
  local launcher=""
  if command -v ccache >/dev/null; then launcher=ccache; fi
  cmake --preset fuzz -B "$build/fuzz" -DCMAKE_CXX_COMPILER_LAUNCHER=$launcher ||
    exit 1
}

# One program per folder, except for core/tracking, which needs the solvers, and
# core/kinematics, which takes minutes.
core_tests() {
  (cd tests && find core -name '*_test.cc' -printf 'test_%h\n') | tr / _ |
    sort -u | grep -v -x -e test_core_tracking -e test_core_kinematics
}

run_tests() {  # PROGRAM...
  configure_instrumented
  local program failed=0
  cmake --build "$build/fuzz" --parallel "$jobs" --target "$@" || return 1
  # Leak detection traces the process, which not every machine allows: it is off
  # unless KINEGRAPH_LEAKS=1.
  ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
  export ASAN_OPTIONS+=:detect_leaks=${KINEGRAPH_LEAKS:-0}
  export UBSAN_OPTIONS=print_stacktrace=1
  for program in "$@"; do
    # Locale tests run commands, which are not built here.
    "$build/fuzz/tests/$program" --gtest_brief=1 --gtest_filter=-Locale.* ||
      failed=1
  done
  ((failed == 0)) || return 1
  echo "$# test programs"
}

readers() {
  local programs
  mapfile -t programs < <(core_tests | grep '^test_core_io')
  run_tests "${programs[@]}"
}

units() {
  local programs
  mapfile -t programs < <(core_tests | grep -v '^test_core_io')
  run_tests "${programs[@]}"
}

corpora() {
  configure_instrumented
  cmake --build "$build/fuzz" --parallel "$jobs" --target fuzz_readers || return 1
  local fuzzer=$build/fuzz/tests/fuzz/fuzz_readers folder count=0 inputs
  export GLOG_minloglevel=3
  for folder in tests/fuzz/regressions/*/; do
    inputs=("$folder"*)
    if ! KINEGRAPH_FUZZ_TARGET=list "$fuzzer" -runs=0 |
      grep -q -x "$(basename "$folder")"; then
      continue
    fi
    KINEGRAPH_FUZZ_TARGET=$(basename "$folder") "$fuzzer" -rss_limit_mb=2048 \
      "${inputs[@]}" || return 1
    count=$((count + ${#inputs[@]}))
  done
  rm -rf "$build/fuzz/tried"
  tests/fuzz/run.py "$fuzzer" 3 "$build/fuzz/tried" || return 1
  echo "$count inputs that once failed, and 3 s of fuzzing per reader"
}

case $1 in
  tidy | single | corpora | readers | units) "$1" ;;
  *)
    echo "unknown check '$1'"
    exit 2
    ;;
esac
