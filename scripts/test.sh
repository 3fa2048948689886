#!/usr/bin/env bash
# Every check of the project, in a virtual environment of its own making.
# Arguments go to pytest: scripts/test.sh tests/store -k resume
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/venv.sh ".[test,dev]"
if [ $# -eq 0 ]; then
  ruff check .
  ruff format --check .
  mypy
fi
python -m pytest -n "${TBI_TEST_JOBS:-auto}" --dist worksteal "$@"
