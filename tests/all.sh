#!/bin/bash
# Checks that take too long for every change; `./kinegraph test --all` runs them
# after all tests. Prints one line per step: outcome, seconds, title. The output
# of a step is in BUILD/all/STEP.log. A step is skipped if a program that it
# needs is not installed; its line names the missing programs.
#
#   tests/all.sh BUILD [STEP...]     default: every step
set -uo pipefail
root=$(cd -P "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
build=$(readlink -f "$1")
shift
logs=$build/all
mkdir -p "$logs"
cd "$root" || exit 1
jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
failed=0

lacks() {  # PROGRAM...; prints those that are not installed
  local program
  for program in "$@"; do
    command -v "$program" >/dev/null || PATH=$PATH:/usr/sbin command -v \
      "$program" >/dev/null || echo -n "$program "
  done
}

# Names of the test programs of the given folders.
programs_of() {  # FOLDER...
  (cd tests && find "$@" -name '*_test.cc' -printf 'test_%h\n' | tr / _ | sort -u)
}

# The results of the tests are written to BUILD/all/PRESET.xml.
# KINEGRAPH_PROGRAMS selects some of the programs.
sanitizer() {  # PRESET PROGRAM...
  local preset=$1 program programs=()
  shift
  for program in "$@"; do
    if [[ " ${KINEGRAPH_PROGRAMS:-$*} " == *" $program "* ]]; then
      programs+=("$program")
    fi
  done
  cmake --preset "$preset" -B "$build/$preset" &&
    cmake --build "$build/$preset" --parallel "$jobs" \
      --target kinegraph_commands "${programs[@]}" &&
    ctest --test-dir "$build/$preset" --parallel "$jobs" \
      --label-regex "^($(IFS='|' && echo "${programs[*]}"))$" \
      --output-on-failure --output-junit "$logs/$preset.xml"
}

# All programs except the cluster tests, which only start programs that other
# tests cover.
asan() {
  local programs
  mapfile -t programs < <(programs_of apps core fuzz solvers |
    grep -v -x test_apps_cluster)
  ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1 \
    UBSAN_OPTIONS=print_stacktrace=1 sanitizer asan "${programs[@]}"
}
# Programs that use threads.
tsan() {
  TSAN_OPTIONS=halt_on_error=1 sanitizer tsan test_core_base \
    test_core_tracking test_solvers_batch test_solvers_session test_apps_batch \
    test_apps_compare
}
commands() { tests/fuzz/commands.py "$build" "${KINEGRAPH_FUZZ_RUNS:-20000}"; }
stream() { tests/apps/faults/long_stream.py "$build" 1 "$logs/stream"; }
slurm() { "$build/tests/test_apps_cluster" --gtest_brief=1; }
# KINEGRAPH_FUZZ_S: seconds per target; continues from the corpus of earlier runs.
fuzz() {
  cmake --preset fuzz -B "$build/fuzz" &&
    cmake --build "$build/fuzz" --parallel "$jobs" --target fuzz_targets &&
    tests/fuzz/run.py "$build/fuzz/tests/fuzz/fuzz_targets" \
      "${KINEGRAPH_FUZZ_S:-60}" "$logs/fuzz"
}
package() {
  (cd "$build" && rm -f kinegraph_*.deb && cpack -G DEB) &&
    tests/install/bare_root.sh "$build"/kinegraph_*.deb "$logs/bare_root"
}
wheel() {
  rm -f "$build"/kinegraph-*.whl
  KINEGRAPH_BUILD=$build packaging/wheel.sh "$build" &&
    tests/install/bare_wheel.sh "$build"/kinegraph-*.whl "$logs/bare_wheel"
}

step() {  # NAME TITLE NEEDED_PROGRAM...
  local name=$1 title=$2 begin=$SECONDS outcome missing
  shift 2
  missing=$(lacks "$@")
  if [[ -n $missing ]]; then
    printf 'SKIPPED          %s: needs %s\n' "$title" "$missing"
    return
  fi
  if "$name" >"$logs/$name.log" 2>&1 </dev/null; then outcome=passed; else
    outcome=FAILED
    failed=1
  fi
  printf '%s  %6d s  %s\n' "$outcome" $((SECONDS - begin)) "$title"
}

wanted=" ${*:-asan tsan commands stream slurm fuzz package wheel} "
run() { if [[ $wanted == *" $1 "* ]]; then step "$@"; fi; }
run commands "whole commands on mutated files" python3
run slurm 'Snakemake, and 40 tasks on a Slurm whose node dies' snakemake \
  slurmctld slurmd munged sbatch
run stream 'an hour of live input at constant memory' python3
run asan 'address and undefined-behaviour sanitizers over the tests' clang++-14
run tsan 'thread sanitizer over programs that use threads' clang++-14
run fuzz 'a minute of fuzzing per target' clang++-14
run package 'the Debian package in a bare root' debootstrap chroot
run wheel 'the wheel in a bare root' debootstrap chroot patchelf
printf "total   %8d s\n" "$SECONDS"
if ((failed)); then echo "logs of the failed steps: $logs"; fi
exit $failed
