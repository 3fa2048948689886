#!/usr/bin/env bash
# From nothing to results: a virtual environment, tbi in it, the paper's 300 km/h case and its 2-200 m/s sweep.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/venv.sh .
mkdir -p results
tbi run paper --overwrite -o results/paper-300kmh.h5
tbi sweep velocity --overwrite -o results/paper-velocity.h5
echo
echo "tbi is installed in $PWD/.venv: run '. .venv/bin/activate' and then 'tbi --help'."
echo "Results: $PWD/results/paper-300kmh.h5 and $PWD/results/paper-velocity.h5"
