"""The benchmark programs of a build, and their times as numbers and words."""
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parents[2]


@dataclass
class Timing:
    """One benchmark's runs: seconds, items per second, counters and label."""
    all_seconds: list = field(default_factory=list)
    all_rates: list = field(default_factory=list)
    all_counters: list = field(default_factory=list)  # dicts
    label: str = ""

    @property
    def seconds(self):
        return statistics.median(self.all_seconds)

    @property
    def rate(self):
        return statistics.median(self.all_rates)

    def counter(self, name):
        return statistics.median(run[name] for run in self.all_counters)

    @property
    def spread(self):
        return (max(self.all_seconds) - min(self.all_seconds)) / self.seconds


class Programs:
    """The programs of a build."""

    def __init__(self, build, repetitions, quick):
        self.build, self.repetitions, self.quick = build, repetitions, quick

    def path(self, name):
        """The program's path; None if it was not built."""
        path = os.path.join(self.build, name)
        return path if os.access(path, os.X_OK) else None

    def run(self, *command):
        """Its standard output; exits with the program's last message if it fails."""
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            said = (done.stderr or done.stdout).strip().splitlines()
            sys.exit(f"{' '.join(map(str, command))} ended with {done.returncode}: {said[-1] if said else 'it said nothing'}")
        return done.stdout

    def time(self, name, only=None):
        """{benchmark: Timing} in order of the runs; empty if the program or its data is missing."""
        if not self.path(name):
            return {}
        print(f"{name} ...", file=sys.stderr, flush=True)
        with tempfile.TemporaryDirectory() as scratch:
            out = os.path.join(scratch, "out.json")
            command = [self.path(name), f"--benchmark_repetitions={self.repetitions}", f"--benchmark_out={out}",
                       "--benchmark_enable_random_interleaving=true", "--benchmark_out_format=json",
                       "--benchmark_min_time=0.05"]
            if only:
                command.append(f"--benchmark_filter={only}")
            self.run(*command)
            if not os.path.exists(out) or os.path.getsize(out) == 0:  # it has nothing to time without the data
                return {}
            with open(out, encoding="utf-8") as file:
                answer = json.load(file)
        units = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
        timings = {}
        for b in sorted(answer.get("benchmarks", []), key=lambda b: b["family_index"]):
            if b.get("error_occurred"):
                sys.exit(f"{name}: {b['run_name']}: {b['error_message']}")
            if b.get("run_type") != "iteration":
                continue
            benchmark = b["run_name"].removesuffix("/real_time")
            seconds = b["cpu_time"] if benchmark == b["run_name"] else b["real_time"]
            timing = timings.setdefault(benchmark, Timing(label=b.get("label", "")))
            timing.all_seconds.append(seconds * units[b["time_unit"]])
            timing.all_rates.append(b.get("items_per_second", 0))
            timing.all_counters.append(b)
        return timings


def spread_of(timings):
    """The range of one benchmark's runs, relative to its median."""
    spreads = [t.spread for t in timings.values()]
    return (f"Runs of one benchmark differ by {100 * statistics.median(spreads):.1f} % of their median (median over benchmarks; "
            f"at most {100 * max(spreads):.0f} %).")


def short(seconds):
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.0f} ns"


def processor():
    """The processor's name, family and model: processors with one name and clock may differ by a third."""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        known = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in file)}
    return (f"{known.get('model name', 'an unknown processor')} (family {known.get('cpu family', '?')}, "
            f"model {known.get('model', '?')}) at {float(known.get('cpu MHz', 'nan')):.0f} MHz")
