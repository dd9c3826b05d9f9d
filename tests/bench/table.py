#!/usr/bin/env python3
"""The benchmark tables and the plots of cost against size.

    tests/bench/table.py [BUILD] [-o FOLDER] [--sections NAME,...] [--repetitions N] [--quick]

Runs the Google Benchmark programs of BUILD (build/release), each benchmark N times in random order, and takes medians: of
processor time, and of wall time where both cores may work. Then `borelli chart`, `peers`, and the program's whole way from
a volume to the report. Programs that were not built (MuJoCo's) or lack their data are left out; if anything fails, nothing
is written. Writes to FOLDER (bench):

    README.md     the tables, between the two lines that name this script if the file has them (tests/bench has)
    bodies.svg    nanoseconds per evaluation against the number of bodies, up to 10000, with fitted exponents
    voxels.svg    milliseconds of one thread's moments against voxels, up to 512 x 512 x 2000
    runs.svg      seconds of whole runs, segmentation, inertia and meshes against voxels, up to as many

With --sections (mujoco, constraints, ensemble, equations, work_precision, recording, floor, moments, volumes, whole_runs, sizes,
peers) only those are renewed and the file's others stay; each names its processor.

The exponent of a curve is the slope of the least squares line through the logarithms of its sizes from 100 bodies or 1e7
voxels on: below that, costs that do not grow with the size still count. --quick leaves out the largest sizes and whole runs.
"""
import argparse
import os
import sys

import dynamics_sections as dynamics
import volume_sections as volumes
from timed_programs import Programs, processor

BEGIN, END = "<!-- tests/bench/table.py: from here -->", "<!-- tests/bench/table.py: to here -->"

SECTIONS = {"mujoco": dynamics.mujoco_section, "constraints": dynamics.constraints_section, "ensemble": dynamics.ensemble_section,
            "equations": dynamics.equations_section, "work_precision": dynamics.work_precision_section,
            "recording": dynamics.recording_section, "floor": dynamics.floor_section, "moments": volumes.moments_section,
            "volumes": volumes.volumes_section, "whole_runs": volumes.whole_runs_section, "sizes": volumes.sizes_section,
            "peers": dynamics.peers_section}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default="build/release")
    parser.add_argument("-o", "--out", default="bench")
    parser.add_argument("--sections", default=",".join(SECTIONS))
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    if asked.repetitions < 1:
        parser.error(f"--repetitions is {asked.repetitions}; expected at least 1")
    wanted = asked.sections.split(",")
    for name in wanted:
        if name not in SECTIONS:
            parser.error(f"there is no section '{name}'; expected some of {', '.join(SECTIONS)}")
    programs = Programs(asked.build, asked.repetitions, asked.quick)
    for name in ("borelli", "equations_bench", "moments_bench", "volumes_bench"):
        if not programs.path(name):
            sys.exit(f"{asked.build} has no {name}: build it with the tests (BORELLI_TESTS=ON)")
    try:
        os.makedirs(asked.out, exist_ok=True)
    except OSError as error:
        sys.exit(f"{asked.out}: {error.strerror}")
    readme = os.path.join(asked.out, "README.md")
    before, made, after = parts_of(readme)
    drawings = {}
    for name in wanted:
        if lines := SECTIONS[name](programs, drawings):  # else what there was of it stays
            made[name] = [*lines, "", f"*{processor()}.*", ""]
    for name, drawing in drawings.items():
        with open(os.path.join(asked.out, name), "w", encoding="utf-8") as file:
            file.write(drawing)
    lines = [f"Medians of {asked.repetitions} runs in random order, of one thread's processor time unless stated otherwise.", ""]
    for name in SECTIONS:
        lines += [f"<!-- {name} -->", *made[name]] if made.get(name) else []
    with open(readme, "w", encoding="utf-8") as file:
        file.write("\n".join([before + BEGIN, *lines, END + after]))
    print("\n".join(lines))


def parts_of(path):
    """The file's text before the tables, {section: its lines}, and the text after them."""
    if not os.path.exists(path):
        return "", {}, "\n"
    with open(path, encoding="utf-8") as file:
        whole = file.read()
    before, begin, rest = whole.partition(BEGIN)
    tables, end, after = rest.partition(END)
    if not begin or not end:
        sys.exit(f"{path} is there and does not say where the tables belong: give another folder (-o)")
    if tables.strip() and not any(f"<!-- {name} -->" in tables for name in SECTIONS):
        sys.exit(f"{path} has tables without a line for each section, such as <!-- mujoco -->: give another folder (-o)")
    made, name = {}, None
    for line in tables.split("\n"):
        if line.startswith("<!-- ") and line[5:-4] in SECTIONS:
            name = line[5:-4]
            made[name] = []
        elif name:
            made[name].append(line)
    for lines in made.values():
        while lines and not lines[-1]:
            lines.pop()
        lines.append("")
    return before, made, after


if __name__ == "__main__":
    main()
