"""The layout of a results file."""

from __future__ import annotations

from scripts.reference.markdown import code, table
from tbi_cli.store import DAF, TABLES
from tbi_cli.store.layout import FORMAT, FORMAT_VERSION
from tbi_cli.store.provenance import provenance

_HEAD = """# Results file

HDF5 in the netCDF-4 data model (format `{format}`, version {version}): dimension scales, `units` and
`long_name` on every variable. xarray, `ncdump`, `h5dump` and MATLAB's `h5read` read it; so does
[`open_results`](python.md). Numbers are float64, `status` is int8.

## Dimensions

The swept axes, in the order of the case file, named as there with dots turned to underscores
(`train.car_body.mass` becomes `train_car_body_mass`; short names stay as they are), each with its coordinate
variable in SI, in every table group. A case without sweep has the one dimension `velocity`, of length 1. Axes
that move together have one dimension that counts their values from 0, named after them
(`velocity_and_bridge_length`), or `sample`; what each key is there stands in the root attribute `case`, under
`sweep`.

The flat index of a scenario counts the grid from 0, the last axis changing fastest.

## Groups

{groups}
NaN stands where nothing was computed. `histories/<flat index>` holds `time` (s, 0 when the first axle enters
the bridge) and one variable per stored channel; its attributes are the scenario's axis values. There is no
such group with `histories: none`.

A file of several [studies](case.md#studies) has one group per study, named after it, and all of this in each:
`/masses/peak`, `/masses/status`.

## Where a refined sweep has converged

With `refine: resonance` the velocity has the speeds that were solved. `/converged` (int8) says of each
scenario whether the sweep's `tolerance` holds there: 0 at the top of a peak of one of the deciding channels
that may still change by more, and where nothing is solved (status 0 and 2); 1 everywhere else. The run ends
with a line that counts such peaks, `tbi info` does so too, and `tbi export` writes a table `converged`. Of an
unfinished run it is as of the last round of speeds. Other sweeps have no such variable.
[How speeds are added](../TRAINS.md#speeds-that-a-sweep-finds-itself).

## Amplification factors

{daf}
They are defined in the [theory](../theory.md#dynamic-amplification-factors). Trains on one beam have the
right ones only. NaN stands for a beam on which nothing presses at rest, as with `gravity: 0`.

## Root attributes

{attributes}
The SHA-256 of the case leaves out `output.file`; number of jobs and backend are no part of a case. Two
results files with one `case_sha256`, written by one version of tbi on one kind of processor, have the same
bits in every table.

## While a run goes on

Each finished batch is at once a file of its own in `RESULTS.h5.parts/`, written under a temporary name,
synced and renamed. At the end they become `RESULTS.h5` the same way, and the folder is gone. `tbi info`, `tbi
status`, `tbi report`, `open_results` and `--resume` read the parts where `RESULTS.h5` is not there yet. A
shard holds full-size tables, with NaN and status 0 outside its part; of a refined sweep, the speeds of its
part. An attribute `refined` names the axis that may still get more values.
"""
_GROUPS = {
    "daf": "dynamic amplification factors of the beams",
    "status": "(a variable) 0 to do, 1 done, 2 failed",
    "converged": "(a variable, of a refined sweep) 1, or 0 where its tolerance was not reached",
    "message": "(a variable, where a scenario failed) why",
    "histories": "time histories, one group per scenario",
}
_ATTRIBUTES = {
    "format": "name of this format",
    "format_version": "its version",
    "title": "title of the case",
    "tbi_version": "version of tbi",
    "case": "the whole resolved case as YAML in SI; it can be run again",
    "case_sha256": "SHA-256 of all that decides the results",
    "command": "the command line; absent where Python made the run",
    "folder": "the folder in which the command was given",
    "shard_command": "of joined shards, the command line of one of them",
    "shard_folder": "of joined shards, the folder in which that was given",
    "created": "when the run began, UTC",
    "host": "name of the computer",
    "numpy_version": "version of numpy",
    "numba_version": "version of numba",
    "h5py_version": "version of h5py",
    "git_revision": "revision of the checkout that tbi ran from, if any",
    "shard": "I/N, of a shard",
    "slurm_job_id": "in a Slurm job, its number",
    "slurm_array_task_id": "in an array job, the task's number",
    "dimensions": "names of the dimensions, in order",
    "channels": "names of the channels in tables, in order",
    "history_channels": "names of the channels in histories, in order",
    "daf": "names of the amplification factors",
    "solve_seconds": "time spent in the solver, summed over threads",
    "case_steps": "Runge-Kutta steps taken",
}


def page() -> str:
    """The page of the results file."""
    written = provenance(case_yaml="-", case_sha256="-", command=["tbi"], title="-", shard="1/1")
    unknown = set(written) - set(_ATTRIBUTES)
    assert not unknown, f"attributes that the page does not explain: {unknown}"
    groups = {name: f"{text} of every channel" for name, text in TABLES.items()} | _GROUPS
    return _HEAD.format(
        format=FORMAT,
        version=FORMAT_VERSION,
        groups=table(["group", "holds"], ([code(f"/{name}"), text] for name, text in groups.items())),
        daf=table(["variable", ""], ([code(v.name), v.long_name] for v in DAF.values())),
        attributes=table(["attribute", ""], ([code(name), text] for name, text in _ATTRIBUTES.items())),
    )
