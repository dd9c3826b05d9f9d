"""pip builds the module without a network, and the installed module works alone."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import program


class Install(unittest.TestCase):
    def test_pip_installs_a_module_that_works(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for file in ["pyproject.toml", "setup.py", "CMakeLists.txt"]:  # pip writes beside them
                shutil.copy(program.source / file, folder)
            environment = {**os.environ, "BORELLI_BUILD": os.environ["BORELLI_BUILD_FOLDER"]}
            subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-build-isolation", "--no-index",
                            "--no-deps", "--target", folder / "there", folder], env=environment, check=True)
            # a mesh page needs neither the build folder nor the program; VTK is loaded on demand
            script = ("import borelli; print(borelli.__file__); "
                      "s = borelli.Scene.from_toml('[[solid]]\\nname=\"a\"\\njoint={rotation=\"y\",name=\"a\"}\\nmass=1\\n"
                      "centre=[0,0,-1]\\ntensor=[0,0,0]'); m = borelli.simulate(s, duration=0.1); m.write('a.h5')")
            environment["PYTHONPATH"] = str(folder / "there")
            said = subprocess.run([sys.executable, "-c", script], env=environment, cwd=folder, check=True,
                                  capture_output=True, text=True).stdout
            self.assertIn(str(folder / "there"), said)
            self.assertTrue((folder / "a.h5").exists())


if __name__ == "__main__":
    unittest.main()
