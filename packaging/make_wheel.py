"""Packs CMake's output into a wheel together with the libraries that it links.

    make_wheel.py BUILD OUT

Every library that is not part of manylinux_2_36 goes into kinegraph.libs, where it
is found by a relative path. It gets a name of its own ("libglog-kinegraph.so.1"), so
that the loader does not use another module's copy.
"""

import base64
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
GLIBC = (2, 36)
# Libraries and symbol versions that PEP 600 allows a wheel to require for this glibc.
EXPECTED = {
    "ld-linux-x86-64.so.2", "libc.so.6", "libm.so.6", "libpthread.so.0",
    "libdl.so.2", "librt.so.1", "libutil.so.1", "libresolv.so.2",
    "libgcc_s.so.1", "libstdc++.so.6", "libz.so.1",
}  # fmt: skip
NEWEST = {
    "GLIBC": GLIBC, "GLIBCXX": (3, 4, 30), "CXXABI": (1, 3, 13),
    "GCC": (12, 0, 0), "ZLIB": (1, 2, 9),
}  # fmt: skip
# Folders of single-threaded BLAS libraries, of which the last existing one is used:
# ATLAS, which Debian's Ceres links, else the reference implementation.
PREFERRED = ["blas", "lapack", "atlas"]
# Packages linked statically, header-only, or embedded in the programs.
INSIDE = ["libceres-dev", "libeigen3-dev", "pybind11-dev", "libjs-three",
          "nlohmann-json3-dev"]  # fmt: skip


def output(*command):
    return subprocess.run(
        [str(part) for part in command], check=True, text=True, stdout=subprocess.PIPE
    ).stdout


def needed(path):
    return re.findall(r"\(NEEDED\).*\[(.+)\]", output("readelf", "-dW", path))


def where(program):
    """Path of each library that the loader finds for a program, by name."""
    found = dict(re.findall(r"(\S+) => (/\S+)", output("ldd", program)))
    for folder in PREFERRED:
        for path in pathlib.Path("/usr/lib").glob(f"*-linux-gnu/{folder}/lib*.so.3"):
            found[path.name] = str(path)
    return found


def own_name(library):
    return library.replace(".so", "-kinegraph.so", 1)


def collect_libraries(programs, libs):
    """Copies the required libraries into `libs`; returns the source of each."""
    paths = {}
    for program in programs:
        paths.update(where(program))
    sources = {}
    wanted = sorted({name for program in programs for name in needed(program)})
    while wanted:
        name = wanted.pop()
        if name in EXPECTED or name in sources:
            continue
        if name not in paths:
            sys.exit(f"make_wheel: error: the library {name} was not found")
        sources[name] = paths[name]
        shutil.copy(paths[name], libs / own_name(name))
        (libs / own_name(name)).chmod(0o755)
        wanted += needed(paths[name])
    return sources


def relink(path, rpath, names):
    """Strips a program or library and sets its search path to kinegraph.libs."""
    output("strip", "--strip-unneeded", path)
    # One change per call: patchelf 0.14 mishandles several at once.
    for name in needed(path):
        if name in names:
            output("patchelf", "--replace-needed", name, own_name(name), path)
    if path.parent.name == "kinegraph.libs":
        output("patchelf", "--set-soname", path.name, path)
    output("patchelf", "--force-rpath", "--set-rpath", rpath, path)


def check(path, names):
    """Fails on libraries or symbols that a machine with glibc 2.36 may lack."""
    own = {own_name(name) for name in names}
    strange = set(needed(path)) - own - EXPECTED
    if strange:
        sys.exit(
            f"make_wheel: error: {path.name} needs {sorted(strange)}, which are neither "
            "in the wheel nor part of manylinux_2_36"
        )
    for kind, version in re.findall(
        r"Name: ([A-Z]+)_([\d.]+)", output("readelf", "-VW", path)
    ):
        number = tuple(int(part) for part in version.split("."))
        if kind in NEWEST and number > NEWEST[kind]:
            sys.exit(
                f"make_wheel: error: {path.name} needs {kind}_{version}, which is "
                "newer than the wheel promises; build on Debian 12"
            )


def package_of(path):
    real = pathlib.Path(path).resolve()
    # dpkg lists some libraries below /lib, from before it became a link to /usr/lib.
    for candidate in (real, str(real).removeprefix("/usr")):
        found = subprocess.run(
            ["dpkg-query", "-S", candidate], capture_output=True, text=True
        ).stdout
        if found:
            return found.split(":")[0]
    sys.exit(f"make_wheel: error: {path} belongs to no Debian package")


def add_licences(sources, folder):
    """Copies kinegraph's licence and the copyright of every included Debian package."""
    folder.mkdir(parents=True)
    for name in ("LICENSE", "third_party_notes.md"):
        shutil.copy(ROOT / name, folder)
    packages = set(INSIDE)
    packages |= {package_of(path) for path in sources.values()}
    lines = []
    for package in sorted(packages):
        shutil.copy(f"/usr/share/doc/{package}/copyright", folder / package)
        lines.append(
            output("dpkg-query", "-Wf", "${Package} ${Version}, source ${source:Package}"
                   " ${source:Version}\n", package).splitlines()[0] + "\n"
        )  # fmt: skip
    (folder / "packages.txt").write_text(
        "This wheel as a whole may be passed on under the terms of the GNU General\n"
        "Public Licence, version 3 or later (third_party_notes.md). It contains these\n"
        "packages of Debian 12, whose sources are in Debian's archive:\n\n"
        + "".join(lines)
    )


def metadata(version):
    return (
        "Metadata-Version: 2.1\n"
        "Name: kinegraph\n"
        f"Version: {version}\n"
        "Summary: 3D motion of people from the 2D poses that calibrated cameras see\n"
        "License: BSD-3-Clause (sources), GPL-3.0-or-later (this binary)\n"
        "Requires-Python: >=3.9\n"
        "Requires-Dist: numpy\n"
        "Provides-Extra: files\n"
        "Requires-Dist: h5py; extra == \"files\"\n"
        "Requires-Dist: scipy; extra == \"files\"\n"
        "Requires-Dist: tomli; extra == \"files\" and python_version < \"3.11\"\n"
        "Description-Content-Type: text/markdown\n\n"
        + (ROOT / "README.md").read_text(encoding="utf-8")
    )


def pack(stage, info, wheel):
    """Writes the archive with its list of hashes; equal files give equal bytes."""
    files = sorted(path for path in stage.rglob("*") if path.is_file())
    record = []
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:

        def add(name, data, mode):
            entry = zipfile.ZipInfo(name)
            entry.external_attr = (0o100000 | mode) << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED, 9)

        for path in files:
            name = path.relative_to(stage).as_posix()
            data = path.read_bytes()
            add(name, data, 0o755 if path.stat().st_mode & 0o100 else 0o644)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest())
            record.append(f"{name},sha256={digest.decode().rstrip('=')},{len(data)}\n")
        name = f"{info}/RECORD"
        add(name, "".join(record) + f"{name},,\n", 0o644)


def stage_files(build, stage, version):
    """Copies package, commands and manual pages; returns the programs and modules."""
    package = stage / "kinegraph"
    shutil.copytree(
        build / "python" / "kinegraph", package,
        ignore=shutil.ignore_patterns("__pycache__"),
    )  # fmt: skip
    folder = package / "bin"
    folder.mkdir()
    shutil.copy(build / "pages" / "kinegraph", folder)
    for program in (build / "apps").glob("kinegraph-*"):
        shutil.copy(program, folder)
    data = stage / f"kinegraph-{version}.data"
    for pattern, place in (
        ("*.1", "share/man/man1"),
        ("kinegraph.bash", "share/bash-completion/completions"),
    ):
        (data / "data" / place).mkdir(parents=True)
        for page in (build / "pages").glob(pattern):
            shutil.copy(page, data / "data" / place / page.name.replace(".bash", ""))
    (data / "scripts").mkdir()
    script = data / "scripts" / "kinegraph"
    shutil.copy(ROOT / "packaging" / "kinegraph_script.py", script)
    for path in (folder / "kinegraph", script):
        path.chmod(0o755)
    commands = [p for p in folder.glob("kinegraph-*") if p.name != "kinegraph-adapters"]
    return [*commands, *package.glob("_kinegraph*.so")]


def main():
    build, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    version = re.search(r"project\(kinegraph VERSION ([0-9.]+)", text).group(1)
    module = next((build / "python" / "kinegraph").glob("_kinegraph*.so"))
    python = "cp" + re.search(r"cpython-(\d+)", module.name).group(1)
    machine = sysconfig.get_platform().split("-")[-1]
    tag = f"{python}-{python}-manylinux_{GLIBC[0]}_{GLIBC[1]}_{machine}"
    info = f"kinegraph-{version}.dist-info"
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        stage = scratch / "stage"
        programs = stage_files(build, stage, version)
        libs = stage / "kinegraph.libs"
        libs.mkdir()
        sources = collect_libraries(programs, libs)
        for program in programs:
            up = "../.." if program.parent.name == "bin" else ".."
            relink(program, f"$ORIGIN/{up}/kinegraph.libs", sources)
        for library in libs.iterdir():
            relink(library, "$ORIGIN", sources)
        for path in [*programs, *libs.iterdir()]:
            check(path, sources)
        add_licences(sources, stage / info / "licenses")
        (stage / info / "METADATA").write_text(metadata(version), encoding="utf-8")
        (stage / info / "WHEEL").write_text(
            "Wheel-Version: 1.0\nGenerator: kinegraph\nRoot-Is-Purelib: false\n"
            f"Tag: {tag}\n"
        )
        wheel = out / f"kinegraph-{version}-{tag}.whl"
        pack(stage, info, wheel)
    print(f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB, {len(sources)} libraries")


main()
