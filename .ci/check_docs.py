"""Runs every command and example of the documentation, so that none of them goes stale.

Python blocks are run, and YAML blocks that are whole graphs. Each ``sh`` block of the Markdown files is run in a
fresh copy of the project, with the commands of the Python that runs this script. Commands that install something are
passed over: CI has installed the project by the same files. The README's command that runs the tests is printed on
request and run by CI itself.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path, kind: str = "sh") -> list[str]:
    """Return the blocks of one kind of a page."""
    return re.findall(rf"^```{kind}\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def scripts(page: Path, folder: Path) -> list[str]:
    """Return what is to be run of a page, as shell scripts; Python and YAML blocks are put into files in `folder`."""
    found = ["\n".join(command_lines(block)) for block in blocks(page)]
    python = "\n".join(blocks(page, "python"))
    if python:
        (folder / "example.py").write_text(python, encoding="utf-8")
        found.append("python example.py")
    for index, block in enumerate(block for block in blocks(page, "yaml") if block.startswith("graphtex:")):
        (folder / f"example-{index}.yaml").write_text(block, encoding="utf-8")
        found.append(f"graphtex run example-{index}.yaml --out example-out --quiet")
    return [script for script in found if script]


def test_command() -> str:
    """Return the README's command that installs and runs the tests."""
    found = [block.strip() for block in blocks(ROOT / "README.md") if "pytest" in block]
    if len(found) != 1:
        sys.exit(f"README.md has {len(found)} blocks that run pytest, one is wanted")
    return found[0]


def command_lines(block: str) -> list[str]:
    """Return a block's commands that are to be run: without installation, with this environment's programs."""
    joined = block.replace("\\\n", " ")
    lines = [line.strip() for line in joined.splitlines() if line.strip() and not line.strip().startswith("#")]
    kept = []
    for line in lines:
        parts = [part.strip() for part in line.split("&&")]
        parts = [part for part in parts if not re.search(r"\bpip install\b|-m venv\b|\bgit clone\b|\bpytest$", part)]
        if parts:
            kept.append(" && ".join(parts).replace(".venv/bin/", ""))
    return kept


def main() -> None:
    """Run all commands; the first that fails ends the script with its status."""
    if "--print-test-command" in sys.argv:
        print(test_command())
        return
    count = 0
    for page in PAGES:
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "graphtex"
            ignore = shutil.ignore_patterns(".git", ".venv", ".ci-venv", "*_cache", "__pycache__", "graphtex-out")
            shutil.copytree(ROOT, copy, ignore=ignore)
            for script in scripts(page, copy):
                print(f"-- {page.relative_to(ROOT)}:\n{script}", flush=True)
                done = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=copy, check=False)
                if done.returncode:
                    sys.exit(f"{page.relative_to(ROOT)}: status {done.returncode}")
                count += 1
    print(f"{count} blocks ran")


if __name__ == "__main__":
    main()
