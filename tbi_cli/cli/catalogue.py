"""`tbi list` and `tbi schema`."""

from __future__ import annotations

from typing import Annotated, Literal

import typer


def list_(
    kind: Annotated[
        Literal["trains", "bridges", "cases"] | None,
        typer.Argument(metavar="KIND", help="trains, bridges or cases."),
    ] = None,
) -> None:
    """Show the built-in trains, bridges and cases.

    With what each of them is, and where its values come from.
    """
    from tbi_cli.case import list_builtin

    found = [builtin for builtin in list_builtin() if kind in (None, f"{builtin.kind}s")]
    heading, width = "", 0
    for builtin in found:
        if builtin.kind != heading:
            heading = builtin.kind
            width = max(len(other.name) for other in found if other.kind == heading)
            print(f"{heading}s")
        print(f"  {builtin.name:{width}}  {builtin.description}")
        if builtin.source:
            print(f"  {'':{width}}  from: {builtin.source}")


def schema(
    kind: Annotated[
        Literal["case", "train", "bridge"],
        typer.Argument(metavar="KIND", help="Of a case, train or bridge file."),
    ] = "case",
) -> None:
    """Print the JSON Schema of case files, for editors.

    Draft 2020-12; editors complete and check by it while a file is written.
    """
    import json

    from tbi_cli.case.schema import json_schema

    print(json.dumps(json_schema(kind), indent=2, ensure_ascii=False))
