#!/usr/bin/env bash
# Builds the scripts of the reports anew, from their sources and from libraries of fixed versions:
#   tools/vendor_js.sh            needs npm and a network
#   tools/vendor_js.sh FOLDER     takes the libraries from FOLDER/node_modules
# The result is committed, so that installing Octant needs neither. A test compares the digest of the
# sources that stands in the first line of each script.
set -euo pipefail
cd "$(dirname "$0")/../reader_design/showing/page"
packages="three@0.187.0 echarts@6.1.0 zrender@6.1.0 tslib@2.3.0 esbuild@0.28.2"
libraries=${1:-}
if [ -z "$libraries" ]; then
  libraries=$(mktemp -d)
  trap 'rm -rf "$libraries"' EXIT
  # shellcheck disable=SC2086
  npm install --prefix "$libraries" --no-save --no-audit --no-fund $packages
fi
modules=$(cd "$libraries" && pwd)/node_modules
for package in $packages; do
  name=${package%@*} wanted=${package#*@}
  found=$(sed -n 's/.*"version": "\(.*\)".*/\1/p' "$modules/$name/package.json" | head -n 1)
  if [ "$found" != "$wanted" ]; then
    echo "$name is $found, but $wanted is wanted" >&2
    exit 1
  fi
done
declare -A parts=(
  [page]="Octant, Apache-2.0"
  [charts]="Octant, Apache-2.0; Apache ECharts, copyright The Apache Software Foundation, Apache-2.0; \
ZRender, copyright Baidu Inc., BSD-3-Clause; tslib, copyright Microsoft Corporation, 0BSD"
  [space]="Octant, Apache-2.0; three.js, copyright three.js authors, MIT"
)
digest=$(cat js/*.js | sha256sum | cut -c 1-16)
for name in page charts space; do
  NODE_PATH=$modules "$modules/.bin/esbuild" "js/$name.js" --bundle --minify --target=es2022 \
    --format=iife --legal-comments=none --charset=utf8 --log-level=warning \
    --banner:js="/* sources $digest; ${parts[$name]} */" --outfile="$name.min.js"
done
{
  printf 'Software in the scripts of a report, with its licences.\n'
  for name in three echarts zrender tslib; do
    printf '\n\n==== %s %s ====\n\n' "$name" \
      "$(sed -n 's/.*"version": "\(.*\)".*/\1/p' "$modules/$name/package.json" | head -n 1)"
    cat "$modules/$name/"LICENSE* "$modules/$name/"NOTICE* "$modules/$name/"licenses/* 2> /dev/null || true
  done
} | sed 's/[[:space:]]*$//' > licences.txt
