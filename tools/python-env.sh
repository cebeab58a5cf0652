#!/bin/sh
# Makes .venv with the packages that tests and benches compare against; does nothing when it is up
# to date.
set -eu
stamp=.venv/requirements.installed
if [ -f "$stamp" ] && cmp -s tests/requirements.txt "$stamp"; then
    exit 0
fi
echo "struna: setting up .venv with the packages of tests/requirements.txt (once)" >&2
if ! python3 -m venv .venv >/dev/null 2>&1; then
    # Debian keeps ensurepip in a package of its own.
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        { apt-get update -qq && apt-get install -y -qq --no-install-recommends python3-venv
        } >/dev/null 2>&1 || true
    fi
    python3 -m venv .venv || {
        echo "struna: python3 cannot make a virtual environment; install python3-venv" >&2
        exit 1
    }
fi
.venv/bin/pip install --quiet --disable-pip-version-check -r tests/requirements.txt || {
    echo "struna: the packages of tests/requirements.txt could not be installed; check the network" >&2
    exit 1
}
cp tests/requirements.txt "$stamp"
