# Sourced by the other scripts: makes the virtual environment .venv beside the checkout's files and enters it.
# $1: what to install, as pip names it (".", ".[test]").
python=${PYTHON:-python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
  echo "tbi needs Python 3.11 or newer; $python is $("$python" -V 2>&1). Set PYTHON to a newer one." >&2
  exit 2
}
[ -x .venv/bin/python ] || "$python" -m venv .venv
. .venv/bin/activate
python -m pip install --quiet --disable-pip-version-check -e "$1"
