#!/usr/bin/env python3
"""Serves a folder, out/web unless told, at http://localhost:8000: `serve.py [FOLDER [PORT]]`. Port 0 is any that is free.

The headers isolate the page from other origins, which gives it finer clocks and would allow it shared memory; the page
works without them as well. Files and folders that are not in the folder are not found, also where links in it lead there.
"""
import functools
import http
import http.server
import os
import sys


class Handler(http.server.SimpleHTTPRequestHandler):
    extensions_map = {**http.server.SimpleHTTPRequestHandler.extensions_map, ".wasm": "application/wasm"}

    def send_head(self):
        try:
            served = self.is_served(self.translate_path(self.path))
        except ValueError:  # a name that no file can have
            served = False
        if served:
            return super().send_head()
        self.send_error(http.HTTPStatus.NOT_FOUND, "File not found")
        return None

    def is_served(self, path):
        """Whether a path, and the page that stands for a folder, lie in the folder when all links are followed."""
        root = os.path.realpath(self.directory)
        pages = [os.path.join(path, page) for page in ("index.html", "index.htm")] if os.path.isdir(path) else []
        for file in (path, *filter(os.path.lexists, pages)):
            real = os.path.realpath(file)
            if os.path.commonpath((root, real)) != root or not (os.path.isfile(real) or os.path.isdir(real)):
                return False
        return True

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
