"""Runs the borelli program, for comparison. CMake sets its path, BORELLI_PROGRAM, and the sources', BORELLI_SOURCE."""
import json
import os
import pathlib
import subprocess

source = pathlib.Path(os.environ["BORELLI_SOURCE"])
samples = source / "samples"


def run(*words, accept=(0,)):
    """Runs the program and returns its standard output."""
    done = subprocess.run([os.environ["BORELLI_PROGRAM"], *map(str, words)], capture_output=True, text=True)
    if done.returncode not in accept:
        raise AssertionError(f"borelli {words} ended with {done.returncode}: {done.stderr}")
    return done.stdout


def answer(*words):
    """The program's answer as JSON."""
    return json.loads(run(*words, "--json"))
