"""The pages belong together: links lead somewhere, the site builds, the reference is what the code says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import DOCS, PROJECT, without_code

PAGES = sorted([*DOCS.rglob("*.md"), *PROJECT.glob("*.md")])
_LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def _anchors(page: Path) -> set[str]:
    """What the headings of a page are called in links."""
    headings = re.findall(r"^#+ (.+)$", without_code(page.read_text(encoding="utf-8")), re.MULTILINE)
    return {re.sub(r"[\s]+", "-", re.sub(r"[^\w\s-]", "", heading).strip().lower()) for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(PROJECT)))
def test_links_lead_somewhere(page: Path) -> None:
    """Files that a page links to are there, within the project, and have the heading named."""
    for link in _LINK.findall(without_code(page.read_text(encoding="utf-8"))):
        if link.startswith(("https://", "mailto:")):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert target.is_relative_to(PROJECT), link
        if anchor:
            assert anchor in _anchors(target), link


def test_the_site_builds(tmp_path: Path) -> None:
    """With --strict every warning of MkDocs is an error: dead links, pages that are not there."""
    built = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path)],
        cwd=PROJECT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    theory = (tmp_path / "theory" / "index.html").read_text(encoding="utf-8")
    # As many formulas as the source has between dollars.
    source = (DOCS / "theory.md").read_text(encoding="utf-8")
    assert theory.count('display="block"') == source.count("$$") // 2
    assert theory.count('display="inline"') == source.replace("$$", "").count("$") // 2
    assert "arithmatex" not in theory
    # A page that is read without a network is complete.
    assert not re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="(?:https?:)?//', theory)


def test_the_reference_is_what_the_code_says() -> None:
    checked = subprocess.run(
        [sys.executable, "scripts/make_reference.py", "--check"],
        cwd=PROJECT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert checked.returncode == 0, f"{checked.stdout}{checked.stderr}\nrun python scripts/make_reference.py"
