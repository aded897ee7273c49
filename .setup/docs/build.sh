#!/usr/bin/env bash
# The documentation site in site/: its own packages from their lock, the verification book, the
# pages, and a look at every link.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
bin=.venv/bin

"$bin/python" -m pip install -qq --no-input --disable-pip-version-check --only-binary :all: \
    --require-hashes -r .setup/docs-lock.txt
rm -rf site .sphinx
# the notebooks' kernels talk over loopback and say so each time
"$bin/sphinx-build" --quiet --fail-on-warning --keep-going -c .setup/docs -d .sphinx/trees \
    notebooks .sphinx/html 2> >(grep -v '^\[IPKernelApp\]\|^$' >&2)
mv .sphinx/html site
"$bin/tactgen" verify --quick --out site/book >/dev/null
"$bin/python" .setup/docs/check_links.py site
echo "site/index.html"
