"""Builds the native part with CMake and puts it beside the Python sources.

KINEGRAPH_BUILD names an existing build folder; if it is not set, the library
is compiled in build/pip, which takes some minutes.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent


def version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(kinegraph VERSION ([0-9.]+)", text).group(1)


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        given = os.environ.get("KINEGRAPH_BUILD")
        folder = pathlib.Path(given) if given else ROOT / "build" / "pip" / "cmake"
        if not given:
            subprocess.run(
                [
                    "cmake",
                    "-S",
                    str(ROOT),
                    "-B",
                    str(folder),
                    "-DCMAKE_BUILD_TYPE=Release",
                    "-DKINEGRAPH_TESTS=OFF",
                    f"-DPython3_EXECUTABLE={sys.executable}",
                ],
                check=True,
            )
        subprocess.run(
            [
                "cmake",
                "--build",
                str(folder),
                "--target",
                "kinegraph_python",
                "--parallel",
                str(os.cpu_count() or 1),
            ],
            check=True,
        )
        built = folder / "python" / "kinegraph"
        target = pathlib.Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        natives = sorted(built.glob("_kinegraph*.so"))
        if len(natives) != 1:
            sys.exit(f"{built}: found {len(natives)} modules, expected one")
        shutil.copy2(natives[0], target)
        shutil.copytree(
            ROOT / "configs", target.parent / "configs", dirs_exist_ok=True
        )


setup(
    version=version(),
    packages=["kinegraph"],
    package_dir={"kinegraph": "python/kinegraph"},
    package_data={"kinegraph": ["*.pyi", "py.typed", "adapters/*.py"]},
    ext_modules=[Extension("kinegraph._kinegraph", sources=[])],
    cmdclass={"build_ext": CMakeBuild},
    options={
        # The default, build/, is CMake's build folder.
        "build": {"build_base": "build/pip"},
        "egg_info": {"egg_base": "build"},
    },
)
