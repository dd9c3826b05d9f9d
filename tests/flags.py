#!/usr/bin/env python3
"""Writes docs/flags.md, the table of all flags, from what the program says: tests/flags.py PROGRAM > docs/flags.md

With --check it compares instead, and refuses a flag that has two meanings, has no meaning, or that no sample, test or
page needs: tests/flags.py PROGRAM --check
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "flags.md"
COLUMN = 32  # where --help begins the meanings

# Flags whose value or meaning differs between verbs on purpose.
DIFFERS = {"--output": "each verb writes something else",
           "--convention": "segment cuts by three conventions, a table may stem from others"}


def options(words):
    """(flag, value, meaning) of each option in the text of --help."""
    found, lines = [], words.splitlines()
    for i, line in enumerate(lines):
        if not re.match(r"  (-\w,)?--[a-z]", line):
            continue
        beside = len(line) > COLUMN and line[COLUMN - 1] == " "
        head, meaning = (line[:COLUMN], line[COLUMN:]) if beside else (line, "")
        for more in lines[i + 1:]:
            if not more.startswith(" " * COLUMN):
                break
            meaning += " " + more.strip()
        flag, _, value = head.strip().partition(" ")
        found.append((flag, value.strip(), meaning.strip()))
    return found


def said(program, *words):
    return subprocess.run([program, *words], capture_output=True, text=True, check=True).stdout


def flags_of(program):
    """The program's own options, and {flag: {(value, meaning): [verbs]}}."""
    general = said(program, "--help")
    verbs = re.findall(r"^  ([a-z]+) ", general.partition("\nSubcommands:\n")[2], re.M)
    table = {}
    for verb in verbs:
        for flag, value, meaning in options(said(program, verb, "--help")):
            if "--help" not in flag:
                table.setdefault(flag, {}).setdefault((value, meaning), []).append(verb)
    return options(general), verbs, table


def cell(text):
    return text.replace("|", "\\|").replace("<", "&lt;")


def page(general, table):
    out = ["# All flags", "",
           "Made by `tests/flags.py build/release/borelli > docs/flags.md`; a test compares it with the program. `borelli VERB --help` groups",
           "a verb's flags by purpose, and `man borelli` has them verb by verb. A TOML file for `--settings` has one table per verb with the same",
           "names without dashes: `[run]`, `work-grid = 2`.", "",
           "## Of every verb", "", "| flag | meaning |", "| --- | --- |"]
    out += [f"| `{f}{' ' + v if v else ''}` | {cell(m)} |" for f, v, m in general if "--help" not in f]
    out += ["", "## Of single verbs", "", "| flag | meaning | verbs |", "| --- | --- | --- |"]
    for flag in sorted(table, key=lambda name: name[name.index("--"):]):
        for (value, meaning), verbs in table[flag].items():
            out.append(f"| `{cell(flag)}{' ' + cell(value) if value else ''}` | {cell(meaning)} | {', '.join(verbs)} |")
    return "\n".join(out) + "\n"


def core(value, meaning):
    """What a flag means before a verb's details and defaults."""
    return re.sub(r"(,| )\.\.\.$", "", value), re.split(r"[;:(]|, which", meaning)[0].strip()


def needed():
    """All text of samples, tests and pages, but for the table itself."""
    files = [ROOT / "README.md"]
    for folder in ("samples", "tests", "docs", "segmentation", ".ci"):
        files += [p for p in (ROOT / folder).rglob("*") if p.suffix in (".md", ".sh", ".py", ".cpp", ".hpp", ".txt", "")]
    own = {PAGE, pathlib.Path(__file__).resolve()}
    return "\n".join(p.read_text(errors="ignore") for p in files if p.is_file() and p not in own)


def faults(verbs, table):
    if len(verbs) < 15:
        yield f"--help lists {len(verbs)} verbs"
    text = needed()
    for flag, rows in table.items():
        name = flag[flag.index("--"):]
        if not all(meaning for _, meaning in rows):
            yield f"{name} has no meaning in --help"
        kinds = {core(*row) for row in rows}
        if len(kinds) > 1 and name not in DIFFERS:
            yield f"{name} has {len(kinds)} meanings: " + " / ".join(sorted(" ".join(kind) for kind in kinds))
        short = flag.split(",")[0] if "," in flag else name
        if not re.search(rf"{re.escape(name)}(?![a-z-])|\s{re.escape(short)}\s", text):
            yield f"{name}: no sample, test or page needs it"


def main():
    general, verbs, table = flags_of(sys.argv[1])
    if "--check" not in sys.argv:
        print(page(general, table), end="")
        return 0
    wrong = list(faults(verbs, table))
    if not PAGE.exists() or PAGE.read_text() != page(general, table):
        wrong.append("docs/flags.md differs from the program; make it again: tests/flags.py PROGRAM > docs/flags.md")
    print("\n".join(wrong), file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
