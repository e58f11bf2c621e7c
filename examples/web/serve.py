#!/usr/bin/env python3
"""Serves a folder, out/web unless told, at http://localhost:8000: `serve.py [FOLDER [PORT]]`. Port 0 is any that is free.

The headers isolate the page from other origins, which gives it finer clocks and would allow it shared memory; the page
works without them as well.
"""
import functools
import http.server
import sys


class Handler(http.server.SimpleHTTPRequestHandler):
    extensions_map = {**http.server.SimpleHTTPRequestHandler.extensions_map, ".wasm": "application/wasm"}

    def end_headers(self):
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        self.send_header("Cache-Control", "no-cache")
        super().end_headers()

    def log_request(self, code="-", size="-"):  # says only what goes wrong
        if str(code) >= "400":
            super().log_request(code, size)


folder = sys.argv[1] if len(sys.argv) > 1 else "out/web"
port = int(sys.argv[2]) if len(sys.argv) > 2 else 8000
try:
    server = http.server.ThreadingHTTPServer(("localhost", port), functools.partial(Handler, directory=folder))
except OSError as error:
    sys.exit(f"serve.py: port {port}: {error.strerror}; name another one: make web-serve PORT=8001")
print(f"{folder} is at http://localhost:{server.server_port}; Ctrl-C ends it", flush=True)
try:
    server.serve_forever()
except KeyboardInterrupt:
    pass
