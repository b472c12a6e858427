"""range_server.py FILE PORT_FILE LOG [cut=N] [ranges=no] [says=N]: serves one file over HTTP, on a port that it writes to PORT_FILE. Each
request is a line of LOG: the path and the range asked for.

cut=N: the first answer ends after N bytes, as if the connection broke. ranges=no: it knows no ranges. says=N: it announces N bytes, or with
N = 0 no number."""

import http.server
import os
import pathlib
import sys

file, port_file, log = sys.argv[1:4]
options = dict(argument.split("=") for argument in sys.argv[4:])
contents = pathlib.Path(file).read_bytes()
cut = int(options.get("cut", "-1"))


class Handler(http.server.BaseHTTPRequestHandler):
    def log_message(self, *arguments):
        pass

    def do_GET(self):
        global cut
        asked = self.headers.get("Range")
        with open(log, "a") as stream:
            stream.write("%s %s\n" % (self.path, asked))
        begin = int(asked.split("=")[1].split("-")[0]) if asked and options.get("ranges") != "no" else 0
        if self.path == "/missing" or begin >= len(contents):
            return self.send_error(404 if self.path == "/missing" else 416)
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
pathlib.Path(port_file + ".new").write_text(str(server.server_port))
os.rename(port_file + ".new", port_file)
server.serve_forever()
