"""Figures as files, drawn side by side in processes of their own."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from tbi_cli.report.plot import HeatPanel, Plot

_COLOURS, _SHADED_COLOURS = 64, 255
# So few figures are drawn before other processes have come up.
_FEW = 4


def save_all(plots: Sequence[Plot], folder: Path, formats: Sequence[str], jobs: int) -> list[bytes]:
    """Saves every figure in every format; returns the small PNG of each, for the page."""
    if jobs == 1 or len(plots) <= _FEW:
        return [save(plot, folder, formats) for plot in plots]
    from joblib import Parallel, delayed

    # The slowest first, so that no process is left with one at the end.
    order = sorted(range(len(plots)), key=lambda k: -len(plots[k].panels))
    tasks = (delayed(save)(plots[k], folder, formats) for k in order)
    pictures: list[bytes] = Parallel(n_jobs=min(jobs, len(plots)))(tasks)
    return [picture for _, picture in sorted(zip(order, pictures, strict=True))]


def save(plot: Plot, folder: Path, formats: Sequence[str]) -> bytes:
    """Saves one figure; returns its small PNG."""
    import matplotlib as mpl

    mpl.use("agg")
    from tbi_cli.report.draw import draw
    from tbi_cli.report.style import in_style

    with in_style():
        figure = draw(plot)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # the layout found now serves every format
        large = io.BytesIO()
        figure.savefig(large, format="png", metadata={"Title": plot.heading, "Software": "tbi"})
        if "png" in formats:
            (folder / f"{plot.name}.png").write_bytes(large.getvalue())
        if "pdf" in formats:
            about = {"Title": plot.heading, "Subject": plot.caption, "Creator": "tbi", "CreationDate": None}
            figure.savefig(folder / f"{plot.name}.pdf", metadata=about)
        if "svg" in formats:
            about = {"Title": plot.heading, "Description": plot.caption, "Creator": "tbi", "Date": None}
            figure.savefig(folder / f"{plot.name}.svg", metadata=about)
    shaded = any(isinstance(panel, HeatPanel) for panel in plot.panels)
    return _small(large, _SHADED_COLOURS if shaded else _COLOURS)


def _small(png: io.BytesIO, colours: int) -> bytes:
    """The same picture in few colours: a third of the bytes."""
    from PIL import Image

    picture = Image.open(png).convert("RGB")
    packed = io.BytesIO()
    few = picture.quantize(colours, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    few.save(packed, "png")
    return packed.getvalue()
