#!/usr/bin/env bash
# Opens the web page in Chromium without a window, and drives it: web_page.js. puppeteer-core, which talks to Chromium, is kept
# beside the page's objects. Exit status 77: there is no browser, or no driver of it, so nothing has been tested.
# usage: web.sh [the page's folder [directory of render and walk_events]], from the project's directory
set -u
page=${1:-out/web} bin=${2:-build} driver=build/web
for browser in chromium chromium-browser google-chrome ''; do command -v "$browser" >/dev/null && break; done
for tool in node python3; do
  command -v $tool >/dev/null || { echo "web.sh: $tool is not installed (make deps-extra)"; exit 1; }
done
[ -n "$browser" ] || { echo "web.sh: Chromium is not installed (make deps-web), the page is not opened"; exit 77; }

# Of the 24th version: later ones ask for a newer node than Debian has.
if [ ! -s "$driver/node_modules/puppeteer-core/package.json" ]; then
  command -v npm >/dev/null || { echo "web.sh: npm is not installed (make deps-web), the page is not opened"; exit 77; }
  echo "web.sh: npm installs puppeteer-core into $driver"
  mkdir -p "$driver"
  PUPPETEER_SKIP_DOWNLOAD=1 npm install --prefix "$driver" --no-save --no-package-lock --no-audit --no-fund --loglevel=error \
    --fetch-timeout=30000 --fetch-retries=1 puppeteer-core@24 >"$driver/npm.txt" 2>&1 ||
    { echo "web.sh: puppeteer-core cannot be installed ($driver/npm.txt says why), the page is not opened"; exit 77; }
fi

: >"$driver/serve.txt" # not the address of before
python3 -u examples/web/serve.py "$page" 0 >"$driver/serve.txt" 2>&1 &
server=$!
trap 'kill $server 2>/dev/null' EXIT
for _ in {1..100}; do
  url=$(grep -o 'http://localhost:[0-9]*' "$driver/serve.txt") && break
  kill -0 $server 2>/dev/null || break
  sleep 0.1
done
[ -n "$url" ] || { cat "$driver/serve.txt"; echo "web.sh: the page is not served"; exit 1; }

PUPPETEER=$driver/node_modules/puppeteer-core CHROMIUM=$(command -v "$browser") node tests/web_page.js "$url" "$page" "$bin"
