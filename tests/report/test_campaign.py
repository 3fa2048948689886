"""All figures and tables of the paper by the two documented commands."""

from __future__ import annotations

import re
import struct
from pathlib import Path

from tests.cli.commands import tbi


def test_the_papers_figures_and_tables_from_two_commands(results: list[Path], tmp_path: Path) -> None:
    ended = tbi("report", *map(str, results), "-o", "report", folder=tmp_path, patience=600)
    assert ended.code == 0, ended.err
    assert "missing" not in ended.out
    folder = tmp_path / "report"
    for number in range(4, 30):
        for kind, start in (("png", b"\x89PNG\r\n"), ("pdf", b"%PDF-"), ("svg", b"<?xml")):
            content = (folder / f"fig{number}.{kind}").read_bytes()
            assert content.startswith(start)
        width, height = struct.unpack(">II", (folder / f"fig{number}.png").read_bytes()[16:24])
        assert width >= 1200 and height >= 600
    for number in range(2, 6):
        assert (folder / f"table{number}.csv").read_text().count("\n") >= 5
    assert {path.stem for path in folder.glob("extremes-*.csv")} == {f"extremes-{p.stem}" for p in results}
    page = (folder / "report.html").read_text()
    assert (folder / "report.html").stat().st_size < 10_000_000
    assert all(f'<figure id="fig{number}">' in page for number in range(4, 30))
    # Nothing is loaded from elsewhere: no element names a source but data of the page itself.
    outside = re.sub(r"<script>.*?</script>", "", page, flags=re.S)
    assert not re.findall(r"""(?:src|href)=["'](?!data:|#)[^"']{0,40}""", outside)


def test_by_default_the_report_is_beside_the_results(campaign: Path, tmp_path: Path) -> None:
    (tmp_path / "masses.h5").write_bytes((campaign / "masses.h5").read_bytes())
    ended = tbi("report", "masses.h5", "--formats", "png", "-q", folder=tmp_path)
    assert (ended.code, ended.out) == (0, ""), ended.err
    assert {path.name for path in (tmp_path / "masses-report").glob("*.png")} == {
        f"fig{number}.png" for number in (11, 12, 13, 14)
    }


def test_the_same_results_make_the_same_files(campaign: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        ended = tbi("report", str(campaign / "masses.h5"), "-o", name, "-q", folder=tmp_path)
        assert ended.code == 0, ended.err
    for file in (tmp_path / "one").iterdir():
        if file.name != "report.html":  # which says when it was made
            assert (tmp_path / "two" / file.name).read_bytes() == file.read_bytes(), file.name
