"""An object store on this machine: moto's S3, behind a proxy that counts bytes and makes faults; and a large log to read a part of."""

import http.client
import os
import socket
import struct
import subprocess
import threading
import time
import urllib.request
import zlib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from slurm import free_port

KEY, SECRET = "AKIACAROMOBJECTSTEST", "secret+of+the+objects+test+0123456789abcd"
BUSY = b"<Error><Code>SlowDown</Code><Message>Reduce your request rate.</Message></Error>"
FAULTS = ["503", "reset", "lost", "slow", "torn", "stale"]


class Proxy(BaseHTTPRequestHandler):
    """Passes requests on. `plan(number, method, path)` names the fault of a request, or none."""

    protocol_version = "HTTP/1.1"
    lock, plan, requests, moved, listed = threading.Lock(), staticmethod(lambda *_: None), 0, 0, {}

    def log_message(self, *_):
        pass

    def pass_on(self):
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        with Proxy.lock:
            Proxy.requests += 1
            fault = Proxy.plan(Proxy.requests, self.command, self.path)
        is_list = self.command == "GET" and "list-type" in self.path
        if isinstance(fault, tuple):
            return self.answer(*fault)
        if fault == "503":
            return self.answer(503, [], BUSY)
        if fault == "reset":
            return self.reset()
        if fault == "torn" and body:
            # The store gets the half of it, and then nothing more.
            with socket.create_connection(("127.0.0.1", self.server.store)) as store:
                head = "".join(f"{name}: {value}\r\n" for name, value in self.headers.items())
                store.sendall(f"{self.command} {self.path} HTTP/1.1\r\n{head}\r\n".encode() + body[: len(body) // 2])
            return self.reset()
        if fault == "slow":
            time.sleep(1)
        store = http.client.HTTPConnection("127.0.0.1", self.server.store)
        store.request(self.command, self.path, body, dict(self.headers))
        answer = store.getresponse()
        content = answer.read()
        headers = [(name, value) for name, value in answer.getheaders() if name.lower() not in ("content-length", "connection", "transfer-encoding", "date", "server")]
        if is_list:
            first = Proxy.listed.setdefault(self.path, content)
            content = first if fault == "stale" else content
        if fault == "lost":
            return self.reset()
        with Proxy.lock:
            Proxy.moved += len(content) if self.command == "GET" else 0
        if fault == "torn":
            headers.append(("Content-Length", str(len(content))))
            self.answer(answer.status, headers, content[: len(content) // 2])
            return self.reset()
        length = [("Content-Length", answer.getheader("Content-Length", "0"))] if self.command == "HEAD" else []
        self.answer(answer.status, headers + length, content)

    do_GET = do_PUT = do_HEAD = do_POST = do_DELETE = pass_on

    def answer(self, status, headers, content):
        self.send_response(status)
        for name, value in headers:
            self.send_header(name, value)
        if not any(name == "Content-Length" for name, _ in headers):
            self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def reset(self):
        self.close_connection = True
        self.wfile.flush()
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.connection.close()


class Store:
    """Up inside `with`."""

    def __init__(self, python):
        self.program, self.port = Path(python).parent / "moto_server", free_port()

    def __enter__(self):
        self.server = subprocess.Popen([self.program, "-H", "127.0.0.1", "-p", str(self.port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.proxy = ThreadingHTTPServer(("127.0.0.1", 0), Proxy)
        self.proxy.daemon_threads, self.proxy.store = True, self.port
        threading.Thread(target=self.proxy.serve_forever, daemon=True).start()
        for _ in range(300):
            try:
                self.put("", b"")
                return self
            except OSError:
                time.sleep(0.1)
        raise RuntimeError("moto does not start")

    def __exit__(self, *_):
        self.proxy.shutdown()
        self.server.terminate()
        self.server.wait()

    def put(self, name, content):
        """Into the bucket, past the proxy; the bucket itself where no name is given."""
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}/bucket/{name}", content, {"Content-Type": "application/octet-stream"}, method="PUT")
        urllib.request.urlopen(request).read()

    def get(self, name):
        signed = {"Authorization": f"AWS4-HMAC-SHA256 Credential={KEY}/20260101/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=0"}
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}/bucket/{name}", headers=signed)
        return urllib.request.urlopen(request).read()

    def env(self, folder, through=True, **more):
        port = self.proxy.server_address[1] if through else self.port
        keys = {"AWS_ACCESS_KEY_ID": KEY, "AWS_SECRET_ACCESS_KEY": SECRET, "AWS_REGION": "us-east-1"}
        address = {"AWS_ENDPOINT": f"http://127.0.0.1:{port}", "AWS_ALLOW_HTTP": "true"}
        return {**os.environ, **keys, **address, "XDG_DATA_HOME": str(folder / "data"), "XDG_CACHE_HOME": str(folder / "cache"), **more}

    def faults(self, plan=lambda *_: None):
        """From now on; the counts begin again. A stale listing is the first one that was asked for."""
        Proxy.plan, Proxy.requests, Proxy.moved = staticmethod(plan), 0, 0

    def counts(self):
        return Proxy.requests, Proxy.moved


def record(opcode, body):
    return bytes([opcode]) + struct.pack("<Q", len(body)) + body


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def records(data, at, end):
    while at < end:
        length = struct.unpack_from("<Q", data, at + 1)[0]
        yield at, data[at], data[at + 9 : at + 9 + length]
        at += 9 + length


def index_of(data):
    summary = struct.unpack_from("<Q", data, len(data) - 8 - 20)[0]
    return summary, list(records(data, summary, len(data) - 8 - 29))


def held(log):
    """Bytes of its chunks."""
    return sum(struct.unpack_from("<Q", body, 24)[0] for _, opcode, body in index_of(log.read_bytes())[1] if opcode == 0x08)


def enlarge(log, topics, size):
    """Makes of an MCAP one with so many further topics of images, in chunks of their own between its chunks, of so many bytes together."""
    data = log.read_bytes()
    summary, index = index_of(data)
    chunks = [body for _, opcode, body in index if opcode == 0x08]
    schema = record(0x03, struct.pack("<H", 900) + text("sensor_msgs/msg/CompressedImage") + text("ros2msg") + text("uint8[] data"))
    channels = b"".join(record(0x04, struct.pack("<HH", 900 + n, 900) + text(f"/camera_{n}/image") + text("cdr") + struct.pack("<I", 0)) for n in range(topics))
    image, out, indexes, moved, images = os.urandom(200_000), bytearray(), [], {}, [0] * topics
    each = max(1, size // len(image) // len(chunks))
    ends = {struct.unpack_from("<Q", body, 16)[0]: body for body in chunks}
    after = None
    for at, opcode, body in [*records(data, 8, summary), (summary, 0, b"")]:
        # Behind a chunk and its indexes.
        if after is not None and opcode != 0x07:
            for n in range(each):
                topic = n % topics
                message = record(0x05, struct.pack("<HIQQ", 900 + topic, 0, after, after) + image)
                chunk = record(0x06, struct.pack("<QQQI", after, after, len(message), zlib.crc32(message)) + text("") + struct.pack("<Q", len(message)) + message)
                begin = 8 + len(out)
                out += chunk
                place = record(0x07, struct.pack("<HIQQ", 900 + topic, 16, after, 0))
                offsets = struct.pack("<IHQ", 10, 900 + topic, 8 + len(out))
                indexes.append(record(0x08, struct.pack("<QQQQ", after, after, begin, len(chunk)) + offsets + struct.pack("<Q", len(place)) + text("") + struct.pack("<QQ", len(message), len(message))))
                out += place
                images[topic] += 1
            after = None
        if opcode == 0x0F:
            break
        if opcode == 0x06:
            after, moved[at] = struct.unpack_from("<Q", body, 8)[0], 8 + len(out) - at
            shift = moved[at]
            old = bytearray(ends[at])
            struct.pack_into("<Q", old, 16, at + shift)
            length = struct.unpack_from("<I", old, 32)[0]
            for place in range(36, 36 + length, 10):
                struct.pack_into("<Q", old, place + 2, struct.unpack_from("<Q", old, place + 2)[0] + shift)
            indexes.append(record(0x08, bytes(old)))
        out += data[at : at + 9 + len(body)]
        if opcode == 0x01:
            out += schema + channels
    out += record(0x0F, struct.pack("<I", 0))
    start = 8 + len(out)
    for at, opcode, body in index:
        if opcode in (0x03, 0x04):
            out += record(opcode, body)
        if opcode == 0x0B:
            messages, schemas, count, *rest = struct.unpack_from("<QHIIIIQQ", body)
            counts = body[46:] + b"".join(struct.pack("<HQ", 900 + n, images[n]) for n in range(topics))
            rest[2] += sum(images)
            statistics = record(0x0B, struct.pack("<QHIIIIQQ", messages + sum(images), schemas + 1, count + topics, *rest) + struct.pack("<I", len(counts)) + counts)
    out += schema + channels + statistics + b"".join(indexes)
    footer = record(0x02, struct.pack("<QQI", start, 0, 0))
    log.write_bytes(data[:8] + out + footer + data[:8])
