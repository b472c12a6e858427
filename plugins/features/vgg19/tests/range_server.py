"""Serves one file over HTTP, on a port of its own that it writes to PORT_FILE. For the tests of fetching.

usage: range_server.py FILE PORT_FILE LOG [cut=N] [ranges=no] [says=N]

cut=N     the first answer ends after N bytes, as if the connection broke.
ranges=no knows no ranges.
says=N    announces N bytes, or with N = 0 no number.

Each request is a line of LOG: the path and the range asked for.
"""

import http.server
import os
import sys

file, port_file, log = sys.argv[1:4]
options = dict(argument.split("=") for argument in sys.argv[4:])
with open(file, "rb") as stream:
    contents = stream.read()
cut = int(options.get("cut", "-1"))


class Handler(http.server.BaseHTTPRequestHandler):
    def log_message(self, *arguments):
        pass

    def do_GET(self):
        global cut
        asked = self.headers.get("Range")
        with open(log, "a") as stream:
            stream.write("%s %s\n" % (self.path, asked))
        if self.path == "/missing":
            self.send_error(404)
            return
        begin = 0
        if asked and options.get("ranges") != "no":
            begin = int(asked.split("=")[1].split("-")[0])
        if begin >= len(contents):
            self.send_error(416)
            return
        self.send_response(206 if begin else 200)
        says = int(options.get("says", len(contents) - begin))
        if says:
            self.send_header("Content-Length", str(says))
        if begin:
            self.send_header("Content-Range", "bytes %d-%d/%d" % (begin, len(contents) - 1, len(contents)))
        self.end_headers()
        body = contents[begin:]
        if cut >= 0:
            body, cut = body[:cut], -1
        self.wfile.write(body)


server = http.server.HTTPServer(("127.0.0.1", 0), Handler)
with open(port_file + ".new", "w") as stream:
    stream.write(str(server.server_port))
os.rename(port_file + ".new", port_file)
server.serve_forever()
