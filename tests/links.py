#!/usr/bin/env python3
"""links.py [ROOT]: checks that each relative link of a Markdown file leads to a file, and its anchor to a heading."""
import pathlib
import re
import subprocess
import sys


def anchors(text):
    """Anchors as GitHub makes them: lower case, blanks as hyphens, other signs dropped."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.S), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent).resolve()
    listed = subprocess.run(["git", "-C", root, "ls-files", "*.md"], capture_output=True, text=True).stdout.split()
    documents = [root / name for name in listed] or list(root.rglob("*.md"))
    dead = []
    for document in documents:
        text = re.sub(r"```.*?```", "", document.read_text(), flags=re.S)
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            file = (document.parent / path).resolve() if path else document
            if not file.exists():
                dead.append(f"{document.relative_to(root)}: {target}: no such file")
            elif anchor and file.suffix == ".md" and anchor not in anchors(file.read_text()):
                dead.append(f"{document.relative_to(root)}: {target}: no such heading")
    print("\n".join(dead) or f"all links of {len(documents)} documents lead somewhere")
    return 1 if dead else 0


if __name__ == "__main__":
    sys.exit(main())
