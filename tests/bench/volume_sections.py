"""The sections of table.py on volumes and whole runs: each gives the lines of its tables, and puts its plots into
`drawings`."""
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

from size_plot import FITTED_FROM, plot
from timed_programs import ROOT, short, spread_of


def moments_section(programs, drawings):
    timings = programs.time("moments_bench", "^(read_bytes|borelli_moments|itk.*)/[01]$|^moments_of_size/[0-9]{1,3}$"
                            if programs.quick else None)
    lines = ["Moments of 16 labels, one thread (`moments_bench`):", "",
             "| of | volume | Gvoxel/s | ours over it |", "| --- | --- | ---: | ---: |"]
    ours = {timing.label: timing.rate for name, timing in timings.items() if name.startswith("borelli_moments")}
    for name, timing in sorted(timings.items()):
        if timing.label in ours and "size" not in name:
            lines.append(f"| {name.split('/')[0].replace('_', ' ')} | {timing.label} | {timing.rate * 1e-9:.2f} | "
                         f"{ours[timing.label] / timing.rate:.2f} |")
    sizes = [(512.0 * 512 * int(name.split("/")[1]), 1e3 * timing.seconds) for name, timing in timings.items()
             if name.startswith("moments_of_size")]
    drawings["voxels.svg"], exponents = plot("Moments of 512 x 512 x n voxels, one thread", "voxels", "ms", {"16 parts": sizes},
                                             FITTED_FROM["voxels"])
    return lines + ["", "![Cost against voxels](voxels.svg)", "", "Cost against voxels up to 512 x 512 x "
                    f"{int(max(sizes)[0] / 512 / 512)}, fitted exponent: {exponents.get('16 parts', float('nan')):.2f}. "
                    + spread_of(timings)]


def volumes_section(programs, _):
    """Rows of operations on a volume: on one core and on all, ours and ITK's, and the ratio on all."""
    timings = programs.time("volumes_bench")
    lines = ["Other operations on a volume, the sample phantom of 3 mm, wall time (`volumes_bench`). They differ in the distances "
             "(ours to the mask, also only up to 20 voxels; ITK's also within it) and in `coarser` (ours along the patient's "
             "axes, ITK's along the scan's):", "",
             "| of | one core | all cores | ITK, one core | ITK, all cores | ratio |",
             "| --- | ---: | ---: | ---: | ---: | ---: |"]
    for name in timings:
        if not name.endswith("/one_core"):
            continue
        row = [timings.get(name.replace("one_core", cores) + of) for of in ("", "/itk") for cores in ("one_core", "all_cores")]
        lines.append(f"| {name.removesuffix('/one_core').replace('_', ' ')} | "
                     + " | ".join(short(t.seconds) if t else "-" for t in row)
                     + f" | {f'{row[3].seconds / row[1].seconds:.2f}' if row[3] else '-'} |")
    return lines + ["", spread_of(timings)]


class WholeRuns:
    """Runs `borelli run` on volumes and reads its records."""

    def __init__(self, programs):
        self.programs = programs
        self.borelli = [programs.path("borelli")]

    def phantom(self, spacing, volume):
        self.programs.run(self.borelli[-1], "phantom", "--spacing", *spacing, "--noise", "20", "-o", volume)

    def voxels(self, volume):
        info = self.programs.run(self.borelli[-1], "info", volume)
        return next(line.split(maxsplit=1)[1] for line in info.splitlines() if line.split()[:1] == ["voxels"])

    def run(self, volume, folder):
        """Wall time (s), peak memory (GiB) and run.json."""
        out = folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        begin = time.monotonic()
        with open(folder / "said", "w+", encoding="utf-8") as said:
            child = subprocess.Popen([*self.borelli, "run", volume, "--sex", "male", "--pose", "standing", "-o", out],
                                     stdout=said, stderr=said)
            _, status, usage = os.wait4(child.pid, 0)
            seconds = time.monotonic() - begin
            said.seek(0)
            if status != 0:
                sys.exit(f"borelli run on {volume} ended with {os.waitstatus_to_exitcode(status)}: {said.read().strip()[-300:]}")
        answer = json.loads(next(out.glob("*/run.json")).read_text(encoding="utf-8"))
        return seconds, usage.ru_maxrss / 2**20, answer  # (of kB)


def whole_runs_section(programs, _):
    """Rows of volumes: wall time from volume to report, median of three and each; memory; slowest stages."""
    if programs.quick:
        return []
    whole = WholeRuns(programs)
    icrp = ROOT.parent / "shared/volumes/icrp_am/AM_hu.nii.gz"
    lines = ["From a volume to the report, picture and all, wall time on all cores (`borelli run`), three runs:", "",
             "| volume | voxels | median (each) | peak memory | slowest stages |", "| --- | --- | ---: | ---: | --- |"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for title, spacing, volume in (("sample phantom, 3 mm", ["3"], folder / "sample.nii.gz"),
                                       ("ICRP male", None, icrp),
                                       ("phantom, as many voxels as a CT of 512 x 512 x 1000", ["1.465", "0.744", "1.788"],
                                        folder / "large.nii.gz")):
            if spacing:
                whole.phantom(spacing, volume)
            elif not volume.exists():
                continue
            print(f"borelli run, {title} ...", file=sys.stderr, flush=True)
            seconds, memory, answers = zip(*(whole.run(volume, folder) for _ in range(3)))
            slowest = ", ".join(f"{stage['stage']} {100 * stage['share']:.0f} %" for stage in answers[-1]["slowest"])
            lines.append(f"| {title} | {whole.voxels(volume)} | {statistics.median(seconds):.1f} s ({', '.join(f'{s:.1f}' for s in seconds)}) | "
                         f"{max(memory):.2f} GiB | {slowest} |")
    return lines


def sizes_section(programs, drawings):
    """Whole runs and their large stages against the voxels of the volume, the phantom up to 512 x 512 x 2000."""
    if programs.quick:
        return []
    whole = WholeRuns(programs)
    curves, most = {}, 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        volume = folder / "phantom.nii.gz"
        for spacing in (["6"], ["4"], ["3"], ["2"], ["1.465", "0.744", "1.788"], ["1.465", "0.744", "0.894"]):
            whole.phantom(spacing, volume)
            voxels = math.prod(int(n) for n in whole.voxels(volume).split(" x "))
            print(f"borelli run, {voxels} voxels ...", file=sys.stderr, flush=True)
            runs = [whole.run(volume, folder) for _ in range(3 if voxels < 1e8 else 1)]
            most = max(most, *(memory for _, memory, _ in runs))
            curves.setdefault("the whole run", []).append((voxels, statistics.median(seconds for seconds, _, _ in runs)))
            for stage in ("segmentation", "inertia", "mesh"):
                seconds = [next(s["seconds"] for s in answer["stages"] if s["stage"] == stage) for _, _, answer in runs]
                curves.setdefault(stage, []).append((voxels, statistics.median(seconds)))
    drawings["runs.svg"], exponents = plot("From a volume to the report: cost against voxels", "voxels", "s", curves,
                                           FITTED_FROM["voxels"])
    return ["![Cost of whole runs against voxels](runs.svg)", "",
            "Whole runs and their large stages against voxels, the phantom up to as many as 512 x 512 x 2000 "
            f"({most:.2f} GiB), medians of three runs, or one run from 1e8 voxels on; fitted exponents from 1e7: " + ", ".join(f"{name} {e:.2f}" for name, e in exponents.items())
            + ". Segmentation always uses a grid of 3 mm. Inertia varies the planes between parts over a sample of the voxels: all of them "
            "at 4 mm, one of 8 at 3 mm, one of 27 at 2 mm."]
