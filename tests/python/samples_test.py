"""The scripts of samples/python run and pass mypy; the stubs match the module."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import program

SCRIPTS = program.samples / "python"


def run(*words):
    done = subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{words}: {done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout


class Scripts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_inertia_from_ct(self):
        scan = self.folder / "small.nii.gz"
        program.run("phantom", "-o", scan, "--spacing", 8, "--stature", 1.5)
        said = run(SCRIPTS / "inertia_from_ct.py", scan)
        self.assertRegex(said, "segmentation: (good|doubtful)")  # voxels of 8 mm are coarse
        self.assertRegex(said, r"thigh_left +\d+\.\d+ +\d+\.\d+ +\d+\.\d+")

    def test_moving_body(self):
        page = self.folder / "page.html"
        said = run(SCRIPTS / "moving_body.py", page)
        self.assertIn("100 of 100 motions are trusted", said)
        self.assertIn("</html>", page.read_text())

    def test_scene_by_hand(self):
        said = run(SCRIPTS / "scene_by_hand.py")
        self.assertIn("trusted: True", said)

    def test_accuracy_against_time(self):
        said = run(SCRIPTS / "accuracy_against_time.py", program.samples / "double_pendulum.toml", self.folder)
        self.assertIn("dop853", said)
        self.assertTrue((self.folder / "chart.html").exists())

    def test_each_script_has_a_test(self):
        tested = {name.removeprefix("test_") for name in dir(self) if name.startswith("test_")}
        self.assertLessEqual({path.stem for path in SCRIPTS.glob("*.py")}, tested)


class Stubs(unittest.TestCase):
    def setUp(self):
        os.environ["MYPYPATH"] = os.environ["PYTHONPATH"]

    def test_samples_pass_mypy(self):
        with tempfile.TemporaryDirectory() as cache:
            run("-m", "mypy", "--strict", "--cache-dir", cache, *sorted(SCRIPTS.glob("*.py")))

    def test_stubs_are_the_modules(self):
        done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "--concise", "borelli"], capture_output=True,
                              text=True)
        # no stub can name pybind11's metaclass nor its __init__; _core's names are those of borelli
        known = ("borelli._core", "metaclass differs", "__init__ is inconsistent", "__init__ does not have")
        told = [line for line in done.stdout.splitlines() if line and not any(word in line for word in known)]
        self.assertEqual(told, [])
        self.assertIn("metaclass differs", done.stdout)  # it did look


if __name__ == "__main__":
    unittest.main()
