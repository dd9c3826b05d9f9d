"""pip install --no-build-isolation . : builds the Python module with CMake and packs what CMake installs.

BORELLI_BUILD names a configured build folder to use, e.g. build/release; otherwise CMake configures one of its own.
"""
import os
import pathlib
import re
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = pathlib.Path(__file__).resolve().parent


class CMakeBuild(build_ext):
    def run(self):
        given = os.environ.get("BORELLI_BUILD")
        build = pathlib.Path(given or self.build_temp).resolve()
        if not given:
            subprocess.run(["cmake", "-S", SOURCE, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                            "-DCMAKE_UNITY_BUILD=ON", "-DBORELLI_TESTS=OFF", "-DBORELLI_PYTHON=ON",
                            f"-DPython_EXECUTABLE={sys.executable}"], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "python_module"], check=True)
        subprocess.run(["cmake", "--install", build, "--component", "python", "--strip",
                        "--prefix", pathlib.Path(self.build_lib).resolve()], check=True)


version = re.search(r"project\(borelli VERSION ([\d.]+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
setup(
    name="borelli",
    version=version,
    description="Turns a CT or MR volume of a person into a body that moves",
    license="Apache-2.0",
    python_requires=">=3.9",
    install_requires=["numpy"],
    packages=[],
    ext_modules=[Extension("borelli._core", sources=[])],  # so that the wheel is of this machine
    cmdclass={"build_ext": CMakeBuild},
)
