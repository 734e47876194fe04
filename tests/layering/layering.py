#!/usr/bin/env python3
"""Checks rules on the sources that the build cannot enforce.

The build itself enforces which library may use which (kinegraph_library).
Prints a line for each violation, and the number of sources. Exit code 1 if
there are violations, or fewer than 500 sources: then some were not found.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'\s*#\s*include\s*[<"]([^>"]+)[>"]')

# Includes allowed in some folders only: pattern of the whole path, folders,
# rule, and a violation (file, line) that tests the rule.
INCLUDES = [
    (r"(ceres|suitesparse)/.*|cholmod.*\.h|umfpack\.h|SuiteSparse.*",
     ["solvers"], "only solvers may include Ceres and SuiteSparse",
     ("core/data/x.h", "#include <ceres/ceres.h>")),
    (r"gflags/.*", ["apps"], "only apps may include gflags",
     ("core/data/x.h", "#include <gflags/gflags.h>")),
    (r"toml\+\+/.*|toml\.hpp|simdjson.*|yaml-cpp/.*",
     ["core/io"], "only core/io may include format libraries",
     ("core/tracking/x.cc", '#include "simdjson.h"')),
    (r"nlohmann/.*", ["core/io", "apps"],
     "only core/io may read JSON; only core/io and apps may write it",
     ("solvers/x.cc", "#include <nlohmann/json.hpp>")),
    (r"fstream|filesystem", ["core/io"], "only core/io may access files",
     ("apps/x.cc", "#include <filesystem>")),
    (r"iostream", ["apps"], "the library does not print",
     ("core/data/x.cc", "#include <iostream>")),
    (r"(sys/.*|unistd|fcntl|poll|spawn|dirent|termios|dlfcn|glob|pwd|pthread|"
     r"sched|signal)\.h|sys/.*|csignal", ["core/system"],
     "only core/system may use the operating system",
     ("apps/x.cc", "#include <sys/stat.h>")),
    (r"tests/.*", [], "only tests may include tests",
     ("core/data/x.h", '#include "tests/support/y.h"')),
]
# The same for patterns in lines that are not includes.
WORDS = [
    (r"\b(FLAGS_\w+|(DEFINE|DECLARE)_(bool|int32|uint32|int64|uint64|double|"
     r"string)\b)", ["apps"], "only apps may use flags",
     ("solvers/window/x.cc", "  if (FLAGS_threads > 1) {")),
    (r"\b(fopen|freopen)\s*\(", ["core/io"],
     "only core/io may access files",
     ("solvers/x.cc", '  FILE* file = fopen(name, "r");')),
    (r"\bstd::(cout|cerr)\b|\b(printf|puts|fprintf)\s*\(", ["apps"],
     "the library does not print", ("core/data/x.cc", '  std::printf("%d", x);')),
    (r"\brandom_device\b", [], "every random number is seeded",
     ("core/data/x.cc", "std::random_device d;")),
]
# Platform-specific code, which docs/porting.md must list.
NOT_EVERYWHERE = re.compile(
    r"#include <(sys/.*|unistd|fcntl|poll|spawn|dirent|termios|dlfcn|glob|pwd|"
    r'pthread|sched)(\.h)?>|"/proc/|__builtin_cpu|vector_size')
TYPE = re.compile(r"^(?:struct|class|enum class) (\w+)(?: final)?"
                  r"(?: :[^;]*)?(?: \{)?$", re.MULTILINE)


def folder_of(path):
    """core/geometry for core/geometry/camera.h; solvers and apps as a whole."""
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] == "core" else parts[0]


def broken_by(path, line):
    """The rules that one line of a source breaks."""
    include = INCLUDE.match(line)
    text = include[1] if include else line.split("//")[0]
    match = re.fullmatch if include else re.search
    return [rule for pattern, allowed, rule, _ in (INCLUDES if include else WORDS)
            if match(pattern, text) and folder_of(path) not in allowed]


def included_by(path, found):
    """Adds all headers that a source includes, directly or not, to the set `found`."""
    for name in INCLUDE.findall((ROOT / path).read_text()):
        if name not in found:
            found.add(name)
            if (ROOT / name).exists():
                included_by(name, found)
    return found


def check_sources(sources):
    porting = (ROOT / "docs/porting.md").read_text()
    types = {}
    for path in sources:
        text = (ROOT / path).read_text()
        if not path.startswith("python/"):
            for number, line in enumerate(text.splitlines(), 1):
                for rule in broken_by(path, line):
                    yield f"{path}:{number}: {rule}: {line}"
        if (NOT_EVERYWHERE.search(text) and
                pathlib.PurePath(path).name not in porting):
            yield f"{path} is not in docs/porting.md"
        # Two types of one name violate the one-definition rule: the linker
        # keeps the functions of one, which corrupt the memory of the other.
        for name in TYPE.findall(text) if path.endswith(".h") else []:
            if types.setdefault(name, path) != path:
                yield f"{name} is defined in {path} and {types[name]}"
        # A file *_avx*.cc is compiled for that instruction set, including the
        # inline functions of library headers, which the linker might then keep
        # for callers on machines without it.
        if re.search(r"_avx\w+\.cc$", path):
            for name in included_by(path, set()):
                if not (ROOT / name).exists() and name not in (
                        "cstdint", "cstddef", "cmath", "algorithm",
                        "type_traits"):
                    yield f"{path} includes {name}"


def check_builds():
    """No build file may select wide vectors: Debian's libceres is built without
    them, and Eigen aligns differently with them, so that memory handed across
    the boundary would be freed wrongly."""
    files = [ROOT / "CMakeLists.txt", ROOT / "CMakePresets.json",
             ROOT / "kinegraph"]
    for top in ["cmake", "core", "solvers", "apps"]:
        files += (ROOT / top).rglob("CMakeLists.txt")
        files += (ROOT / top).rglob("*.cmake")
    for file in files:
        # Except for the files of one instruction set, see above.
        text = re.sub(r'source MATCHES "_avx\w+[^"]*"\)\s*'
                      r"list\(APPEND options -mavx\w+\)", "", file.read_text())
        if "-march=" in text or "-mavx" in text:
            yield f"{file} selects the instruction set of the build machine"


def main():
    sources = [str(path.relative_to(ROOT))
               for top in ["core", "solvers", "apps", "python"]
               for path in sorted((ROOT / top).rglob("*"))
               if path.suffix in (".h", ".cc")]
    found = [*check_sources(sources), *check_builds()]
    for *_, rule, (path, line) in INCLUDES + WORDS:
        if broken_by(path, line) != [rule]:
            found.append(f"'{line}' in {path} does not break: {rule}")
    for path, line in [("core/io/x.cc", "#include <filesystem>"),
                       ("solvers/x.cc", "#include <ceres/ceres.h>"),
                       ("apps/x.cc", 'DEFINE_string(out, "", "");'),
                       ("core/io/x.cc", 'std::snprintf(text, 3, "%d", 1);'),
                       ("core/data/x.h", "// FLAGS_x is not used")]:
        found += [f"'{line}' in {path} breaks: {rule}"
                  for rule in broken_by(path, line)]
    print(*found, f"{len(sources)} sources", sep="\n")
    sys.exit(1 if found or len(sources) < 500 else 0)


if __name__ == "__main__":
    main()
