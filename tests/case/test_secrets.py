"""A case from a stranger may name any file: what is in those outside its folder is not shown."""

from __future__ import annotations

from pathlib import Path

import pytest

from tbi_cli.case import CaseError, load_case

CASE = """\
bridge: {length: 20, right: {youngs_modulus: 35 GPa, second_moment: 0.5, mass_per_length: 15 t/m, damping: 1}}
velocity: 50
"""
SECRETS = {
    "shadow": "root:$6$hunter2$x:19000:0:99999:7:::\nbin:*:hunter2:0:99999:7:::\n",
    "plain": "hunter2\n",
    "mapping": "model: hunter2\npassword: hunter2 hunter2\n",
    "of a train": "model: moving-load\nforces: [hunter2]\npositions: [hunter2]\nhunter2 x: &hunter2 1\n",
    "tag": "!hunter2 x\n",
    "alias": "a: *hunter2\n",
    "table": "position,force\n0,hunter2\n",
    "heading": "hunter2;x\n1;2\n",
    "units": "x [m],right [hunter2]\n0,1\n1,0\n",
    "units of forces": "position [hunter2];force [kN]\n0;1\n",
    "another column": "position;force;hunter2 x;x;right\n0;1;2;0;1\n1;1;2;1;1\n",
    "a comment": "# hunter2 x\n0,1\n1,0\n",
    "spacings": "spacing,force\nhunter2,1\n",
    "decimal commas": "x;right\n0,5 hunter2;1\n",
    "a row too long": "position,force\n0,1,hunter2\n",
    "blanks": "hunter2 position force\n0 1 hunter2\n",
    "twice": "hunter2 2: 1\nhunter2 2: 2\n",
    "bytes": "hunter2\udcff",
    "control": "hunter2 \x07",
}
KEYS = (
    "train: {}",
    "train: {{model: axle-forces, csv: {}}}",
    "train: {{consist: [{{vehicle: {}, spacing: 20}}]}}",
    "train: paper\nbridge: {}",
    "train: paper\ntrack: {{irregularity: {{profile: {{csv: {}}}}}}}",
)


def said_of(case: Path, strict: bool) -> str:
    """What is wrong with a case, or odd about it."""
    try:
        return "\n".join(load_case(case, strict=strict).warnings)
    except CaseError as error:
        return str(error)


@pytest.mark.parametrize("secret", SECRETS.values(), ids=SECRETS)
def test_what_is_in_other_folders_is_not_shown(tmp_path: Path, secret: str) -> None:
    folder = tmp_path / "case"
    folder.mkdir()
    (tmp_path / "secret").write_bytes(secret.encode("utf-8", "surrogateescape"))
    (folder / "link.yaml").symlink_to(tmp_path / "secret")
    case = folder / "case.yaml"
    for key in KEYS:
        for name in ("../secret", "link.yaml", str(tmp_path / "secret")):
            case.write_text(key.format(name) + ("\n" + CASE.split("\n", 1)["bridge:" in key]))
            for strict in (False, True):
                assert "hunter2" not in said_of(case, strict)
    with pytest.raises(CaseError) as caught:
        load_case(folder / "link.yaml")
    assert "hunter2" not in str(caught.value)


def test_what_is_in_the_folder_of_the_case_is_shown(tmp_path: Path) -> None:
    """Its own trains, in folders below too; and of others the keys, each with its place."""
    (tmp_path / "case" / "trains").mkdir(parents=True)
    case = tmp_path / "case" / "case.yaml"
    train = "model: moving-load\nforces: [1 kn]\npositions: [0]\n"
    for name in ("case/trains/own.yaml", "other.yaml"):
        (tmp_path / name).write_text(train)
    texts = []
    for name in ("trains/own.yaml", "../other.yaml"):
        case.write_text(f"train: {name}\n{CASE}")
        with pytest.raises(CaseError) as caught:
            load_case(case)
        texts.append(str(caught.value))
    assert '"1 kn"' in texts[0]
    assert "    2 | forces: [1 kn]" in texts[0]
    assert texts[1].startswith(f"{case.parent}/../other.yaml:2:10: train.forces.0: expected ")
    assert "1 kn" not in texts[1]
    assert "\n" not in texts[1]
