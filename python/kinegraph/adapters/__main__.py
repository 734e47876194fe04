"""kinegraph-adapters: prints files of other programs as kinegraph's JSON Lines.

    kinegraph-adapters FILE                its content, on standard output
    kinegraph-adapters --recognise FILE    kind and format; nothing if unknown
    kinegraph-adapters --write=FORMAT      tracks from standard input, in this format
    kinegraph-adapters --packages FILE...  missing Debian packages that these files require
    kinegraph-adapters --list              the formats

--format=NAME specifies the format of FILE. The user's options are passed as --joints=N
(of the user's skeleton), --first_frame=N and --frame_rate=HZ. KINEGRAPH_ADAPTERS is a
folder with programs of the user, which are tried after the adapters listed by --list.
Exit code 2: wrong usage, or the file cannot be read or written; one line on standard error
gives the reason.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import os
import pathlib
import signal
import subprocess
import sys

# One thread suffices; the stacks and buffers of others would count against the limit
# of limit_memory().
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from common import Options, Refusal, most_bytes

# In the order of recognition. Each is a module with KIND, PACKAGES (the Python modules
# that it requires), recognise(path), and read(path, options) or write(lines, out) or both.
FORMATS = ["sleap", "deeplabcut_h5", "freemocap", "caliscope", "opencap", "acinoset", "tum",
           "movement"]  # fmt: skip
KINDS = ("cameras", "detections", "tracks")


class Usage(Exception):
    pass


def load(name):
    if name not in FORMATS:
        raise Usage(f"--format: found '{name}', expected one of {', '.join(FORMATS)}")
    return importlib.import_module(name)


def own_programs():
    """Executables in the user's folder, sorted by name."""
    folder = os.environ.get("KINEGRAPH_ADAPTERS", "")
    if not folder:
        return []
    folder = os.path.abspath(folder)
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise Usage(f"KINEGRAPH_ADAPTERS: {folder}: {error.strerror}") from error
    paths = [os.path.join(folder, name) for name in names if name[0] != "."]
    return [p for p in paths if os.path.isfile(p) and os.access(p, os.X_OK)]


def kind_by(program, path):
    """The kind of the file according to a user's program; None: not recognised."""
    try:
        asked = subprocess.run(
            [program, "--recognise", str(path)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=20,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Usage(f"{program}: {error}") from error
    words = asked.stdout.decode("utf-8", "replace").split()
    known = asked.returncode == 0 and words and words[0] in KINDS
    return words[0] if known else None


def recognise(path):
    """Kind, and the format or the user's program; None if unknown."""
    for name in FORMATS:
        module = load(name)
        if module.recognise(path):
            return module.KIND, name
    for program in own_programs():
        kind = kind_by(program, path)
        if kind:
            return kind, program
    return None


def lacking(module):
    return [name for name in module.PACKAGES if importlib.util.find_spec(name) is None]


def limit_memory(path):
    """Limits address space to present use + 512 MiB + most_bytes(size of all files)."""
    try:
        import resource

        pages = int(pathlib.Path("/proc/self/statm").read_text().split()[0])
    except (ImportError, OSError):
        return  # not available on every system
    stored = 0
    for folder, _, files in os.walk(path) if path.is_dir() else [(path.parent, [], [path.name])]:
        for name in files:
            with contextlib.suppress(OSError):  # dangling links
                stored += os.path.getsize(os.path.join(folder, name))
    limit = pages * os.sysconf("SC_PAGE_SIZE") + (512 << 20) + most_bytes(stored)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def read(path, name, options):
    if not name:
        found = recognise(path)
        if found is None:
            raise Refusal(path, "", "has a format that no adapter can read")
        name = found[1]
    if os.path.isabs(name):  # a user's program
        os.execv(name, [name, *(a for a in sys.argv[1:] if not a.startswith("--format="))])
    limit_memory(path)
    for text in load(name).read(path, options):
        sys.stdout.buffer.write(text)


def run(arguments):
    flags = {}
    paths = []
    for argument in arguments:
        if argument.startswith("--"):
            key, _, value = argument[2:].partition("=")
            flags[key] = value
        else:
            paths.append(pathlib.Path(argument))
    options = Options(
        int(flags.pop("joints")) if "joints" in flags else None,
        int(flags.pop("first_frame", 0)),
        float(flags.pop("frame_rate")) if "frame_rate" in flags else None,
    )
    name = flags.pop("format", "")
    if flags.keys() == {"list"} and not paths:
        for name in FORMATS:
            print(name, load(name).KIND, *load(name).PACKAGES)
    elif flags.keys() == {"packages"}:
        found = [recognise(path) for path in paths]
        needed = [load(f[1]) for f in found if f and f[1] in FORMATS]
        for lack in sorted({name for module in needed for name in lacking(module)}):
            print(f"python3-{lack}")
    elif flags.keys() == {"write"} and not paths:
        load(flags["write"]).write(sys.stdin.buffer, sys.stdout.buffer)
    elif flags.keys() == {"recognise"} and len(paths) == 1:
        found = recognise(paths[0])
        if found:
            print(*found)
    elif not flags and len(paths) == 1:
        read(paths[0], name, options)
    else:
        raise Usage(f"found {' '.join(arguments) or 'nothing'}, expected: {__doc__}")
    sys.stdout.flush()


def main():
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # end when the reader does
    try:
        run(sys.argv[1:])
    except ModuleNotFoundError as error:
        sys.exit(
            fail(
                f"needs Python's {error.name}: apt-get install python3-{error.name}, or "
                "in a virtual environment pip install 'kinegraph[files]'"
            )
        )
    except MemoryError:
        sys.exit(fail("requires more memory than its size justifies"))
    except (Refusal, Usage, OSError, ValueError) as error:
        sys.exit(fail(str(error)))


def fail(message):
    print(" ".join(message.split()), file=sys.stderr)
    return 2


if __name__ == "__main__":
    main()
