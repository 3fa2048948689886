"""Writes the reference pages of the documentation, docs/reference/, from the code.

python scripts/make_reference.py            # writes them
python scripts/make_reference.py --check    # exit code 1 if one of them is not what the code says
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from scripts.reference import case_keys, channels, command_line, python_api, results_file

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "reference"
NOTICE = "<!-- Written by scripts/make_reference.py: change the code, not this page. -->\n\n"
PAGES = {
    "cli.md": command_line.page,
    "case.md": case_keys.page,
    "channels.md": channels.page,
    "results.md": results_file.page,
    "python.md": python_api.page,
}


def main(arguments: list[str]) -> int:
    """Writes the pages, or checks them; returns the exit code."""
    stale = []
    for name, page in PAGES.items():
        path = FOLDER / name
        text = NOTICE + page().rstrip() + "\n"
        if path.is_file() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(name)
        if "--check" not in arguments:
            FOLDER.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    for name in stale:
        verb = "is not what the code says" if "--check" in arguments else "written"
        print(f"docs/reference/{name} {verb}")
    return 1 if stale and "--check" in arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
