"""Asks examples/web/serve.py for what is in its folder, and for what is not: names with a zero byte, links that lead out, ways
up. Each refusal has a control that is served. usage: serve.py"""
import http.client
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
checks = failures = 0


def check(good, sentence):
    global checks, failures
    checks += 1
    failures += not good
    print(f"  {'ok     ' if good else 'FAILED '} {sentence}")


def answer(port, path):
    """The status and the body of what is said to a request; 0 where nothing is."""
    connection = http.client.HTTPConnection("localhost", port, timeout=10)
    try:
        connection.request("GET", path)
        response = connection.getresponse()
        return response.status, response.read()
    except (OSError, http.client.HTTPException) as error:
        return 0, repr(error).encode()
    finally:
        connection.close()


with tempfile.TemporaryDirectory() as room:
    folder, outside = pathlib.Path(room, "web"), pathlib.Path(room, "web-secret")
    for path in (folder / "inner", folder / "listed", outside):
        path.mkdir(parents=True)
    (outside / "secret.txt").write_text("SECRET")
    (outside / "index.html").write_text("SECRET")
    (folder / "page.txt").write_text("PAGE")
    (folder / "inner" / "index.html").write_text("INNER")
    (folder / "link_in.txt").symlink_to("page.txt")
    (folder / "link_out.txt").symlink_to(outside / "secret.txt")
    (folder / "up.txt").symlink_to("../web-secret/secret.txt")
    (folder / "folder_out").symlink_to(outside, target_is_directory=True)
    (folder / "listed" / "index.html").symlink_to(outside / "secret.txt")
    (folder / "nowhere.txt").symlink_to("absent")
    (folder / "round.txt").symlink_to("round.txt")
    os.mkfifo(folder / "pipe")
    shown = pathlib.Path(room, "shown")  # the folder may be a link itself
    shown.symlink_to(folder, target_is_directory=True)

    server = subprocess.Popen([sys.executable, "-u", ROOT / "examples" / "web" / "serve.py", shown, "0"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        port = int(server.stdout.readline().split("http://localhost:")[1].split(";")[0])
        for path, body in (("/page.txt", b"PAGE"), ("/link_in.txt", b"PAGE"), ("/inner/", b"INNER")):
            check(answer(port, path) == (200, body), f"control: {path} is served")
        check(answer(port, "/inner")[0] == 301, "control: a folder's name leads to the folder")
        check(b"page.txt" in answer(port, "/")[1], "control: a folder without a page is listed")
        for path in ("/%00", "/page.txt%00", "/page.txt%00.html", "/inner%00/", "/%ed%a0%80", "/absent", "/" + 300 * "a",
                     "/link_out.txt", "/up.txt", "/folder_out/secret.txt", "/folder_out/", "/folder_out", "/listed/",
                     "/nowhere.txt", "/round.txt", "/pipe", "/../web-secret/secret.txt",
                     "/%2e%2e/web-secret/secret.txt", "/inner/..%2f..%2fweb-secret/secret.txt"):
            status, body = answer(port, path)
            check(status == 404 and b"SECRET" not in body, f"{path[:40]} is not found: {status}")
        check(answer(port, "/page.txt") == (200, b"PAGE"), "control: what is there is served afterwards")
    finally:
        server.terminate()
        errors = server.communicate()[1]
    check("Traceback" not in errors, "no request ends in a traceback")

print(f"test-serve: {checks - failures} of {checks} checks passed")
sys.exit(failures != 0)
