#!/usr/bin/env bash
# Set-up behind the Makefile: system libraries, .venv from the lock, this package editable.
# Idempotent. What the user has to mend is one sentence and exit code 2.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() {
    printf '%s\n' "$*" >&2
    exit 2
}

# someone else's packages or a --user default must not leak into the environment
unset PYTHONPATH PYTHONHOME
export PIP_USER=0 PIP_DISABLE_PIP_VERSION_CHECK=1

python=${PYTHON:-python3}
command -v "$python" >/dev/null ||
    die "tactgen needs Python 3.11 or newer, but there is no '$python' here: install it, or name another one with 'make setup PYTHON=/path/to/python3'."
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    die "tactgen needs Python 3.11 or newer, but '$python' is $("$python" -c 'import platform; print(platform.python_version())'): name a newer one with 'make setup PYTHON=/path/to/python3'."
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
    die "Python's venv module is incomplete: run 'sudo apt-get install -y python3-venv', then make again."

# soname:Debian package, wanted by the cadquery and VTK wheels, which do not carry them
libraries="libGL.so.1:libgl1 libOSMesa.so.8:libosmesa6"

missing_packages() {
    # really load each one: a cache entry alone proves nothing, and ldconfig may not be on PATH
    "$python" - $libraries <<'PY'
import ctypes
import sys

for item in sys.argv[1:]:
    soname, package = item.split(":")
    try:
        ctypes.CDLL(soname)
    except OSError:
        print(package)
PY
}

apt_install() {
    DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends "$@" </dev/null
}

if [ "$(uname -s)" = Linux ]; then
    packages=$(missing_packages | xargs)
    if [ -n "$packages" ]; then
        command="apt-get install -y --no-install-recommends $packages"
        if ! command -v apt-get >/dev/null; then
            die "Install the libraries that Debian packages as '$packages', then run make again."
        elif [ "$(id -u)" -ne 0 ]; then
            die "System libraries are missing: run 'sudo apt-get update && sudo $command', then make again."
        fi
        echo "Installing system libraries: $packages"
        # package lists may be absent or stale: refresh them only if needed
        log=$(apt_install $packages 2>&1) ||
            log=$(apt-get update -qq 2>&1 && apt_install $packages 2>&1) || {
            printf '%s\n' "$log" >&2
            die "System libraries could not be installed: run '$command', mend what it reports, then make again."
        }
        [ -z "$(missing_packages)" ] ||
            die "'$packages' are installed but cannot be loaded: check the library path, then run make again."
    fi
fi

venv=.venv
stamp=$venv/.ready
here=$(pwd -P)
key=$("$python" - <<'PY'
import hashlib
import json
import pathlib
import tomllib

project = tomllib.loads(pathlib.Path("pyproject.toml").read_text("utf-8"))
parts = {name: project[name] for name in ("build-system", "project", "dependency-groups")}
text = pathlib.Path(".setup/lock.txt").read_text("utf-8") + json.dumps(parts, sort_keys=True)
print(hashlib.sha256(text.encode()).hexdigest())
PY
)

# the stamp is written last, so without it, or after a move (scripts hold absolute paths),
# nothing in the environment can be trusted
if [ "$(tail -n 1 "$stamp" 2>/dev/null || true)" != "$here" ] ||
    ! "$venv/bin/python" -c '' 2>/dev/null; then
    rm -rf "$venv"
elif [ "$(head -n 1 "$stamp")" = "$key" ]; then
    touch "$stamp"
    exit 0
fi

rm -f "$stamp"
pip() {
    "$venv/bin/python" -m pip "$@"
}
if [ ! -d "$venv" ]; then
    "$python" -m venv "$venv" || die "No virtual environment could be made in '$here/$venv'."
fi
echo "Installing the locked packages into $venv (0.8 GB to download the first time) ..."
pip install -qq --no-input --only-binary :all: --require-hashes -r .setup/lock.txt ||
    die "The locked packages could not be installed: mend what pip reports above, then run make again."
pip install -qq --no-input --no-deps --no-build-isolation --editable . ||
    die "The package itself could not be installed: mend what pip reports above, then run make again."

printf '%s\n%s\n' "$key" "$here" >"$stamp.new"
mv "$stamp.new" "$stamp"
