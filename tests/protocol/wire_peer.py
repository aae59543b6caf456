"""A peer that knows only protocol/README.md: packs datagrams with struct and writes them to stdout, each behind its
length (uint32). `wire_peer.py tracker` packs blocks of a Vicon Tracker, `wire_peer.py client` the messages of
tests/protocol/client_samples.cpp."""

import struct
import sys


def name(text):
    return text.encode("ascii").ljust(24, b"\0")


def tracker_object(text, translation, rotation):
    return struct.pack("<BH", 0, 72) + name(text) + struct.pack("<6d", *translation, *rotation)


def tracker_datagrams():
    """Frames 4294967290 and up, five objects each, in blocks of at most 256 bytes padded with zeros."""
    for k in range(20):
        frame = (4294967290 + k) % 2**32
        objects = [
            tracker_object(f"A{i}", (k + 0.5, -i, 100.0 * i + k), (0.001 * k, -0.125 * i, 3.0))
            for i in range(5)
        ]
        for begin in range(0, len(objects), 3):
            block = objects[begin:begin + 3]
            yield (struct.pack("<IB", frame, len(block)) + b"".join(block)).ljust(256, b"\0")


def client_bodies():
    yield 0x01, name("watcher")
    yield 0x02, struct.pack("<B", 3)
    yield 0x03, b""
    yield 0x04, struct.pack("<B", 8)
    yield 0x05, struct.pack("<B", 3)
    yield 0x06, b""
    yield 0x07, struct.pack("<BBHd", 5, 8, 600, 62.5)
    yield 0x08, b""
    yield 0x81, (name("0.1.0") + name("table1") + name("kf-admm") + name("mm s N")
                 + struct.pack("<dIIIHHH", 100.5, 101, 102, 103, 104, 105, 106))
    yield 0x82, struct.pack("<BBHH", 2, 3, 9, 5) + name("A1") + name("pad of 24 characters :-)") + name("A3")
    yield 0x83, predictions()
    for size in (4, 8):
        per_chunk = {4: 110, 8: 55}[size]
        body = struct.pack("<IHHQQIIBBH", 21, 2, 3, 22, 23, 2 * per_chunk + 4, 2 * per_chunk, 4, size, 0)
        for i in range(4):
            body += struct.pack({4: "<3f", 8: "<3d"}[size], 0.5 + i, -1.5 * i, 100.25)
        yield 0x84, body
    for corners in (4, 3):
        per_chunk = {4: 84, 3: 112}[corners]
        body = struct.pack("<BBHHHIII", corners, 3, 0, 1, 2, 70000, per_chunk + 3, per_chunk)
        for i in range(3):
            body += struct.pack(f"<{corners}I", *(i, 1000 + i, 69999 - i, 300 + i)[:corners])
        yield 0x85, body
    yield 0x86, (struct.pack("<BBBBHH8Qdd", 1, 2, 3, 2, 0x0403, 31, *range(32, 40), 99.5, 98.5)
                 + alarm(51, 52, 1.25, 0.375, (-16, 17, -18))
                 + struct.pack("<HQ", 100, 0x0102030405060708) + struct.pack("<HQ", 101, 0))
    yield 0x87, struct.pack("<BBHd", 2, 4, 0, 0.5)
    yield 0xFF, struct.pack("<BBBB", 0, 6, 0x7E, 0)
    yield 0x09, b""
    yield 0x88, probe_view()
    yield 0x0A, bytes(range(0x10, 0x20))
    yield 0x89, bytes(range(0xA0, 0xB0))


def alarm(frame, nanoseconds, level, misfit, place):
    return struct.pack("<BBHIQ5d", 7, 0, 0, frame, nanoseconds, level, misfit, *place)


def predictions():
    body = struct.pack("<BBBBHHHHI5Q3d", 1, 3, 2, 1, 0x0102, 11, 12, 13, 14, 15, 16, 17, 18, 19, 0.25, 0.5, 0.75)
    body += alarm(41, 42, 1.5, 0.125, (13, -14, 15)) + struct.pack("<BBH", 2, 3, 0)
    body += struct.pack("<HBB12d", 10, 1, 0, 1, 2, 3, 4, -5, 6, 7, -8, 9, 10, 11, 12)
    body += struct.pack("<HBB12d", 11, 0, 0, -1, -2, -3, 0, 0, 0, 0, 0, 0, 0, 0, 0)
    body += struct.pack("<HH3d", 8, 0, 1.5, -2.5, 3.5)
    body += struct.pack("<HH3d", 9, 0, -4.5, 5.5, -6.5)
    body += struct.pack("<HH3d", 10, 0, 7.5, 8.5, 9.5)
    return body


def probe_view():
    body = struct.pack("<BBBBHHHHI3Q3dHH2dBBH", 1, 2, 2, 3, 0x0205, 2, 3, 0, 61, 62, 63, 64, 0.5, -1.5, -2.5, 640, 480,
                       0.125, 0.25, 2, 0, 0)
    body += struct.pack("<HBB7d", 20, 1, 0, 100.5, -200.25, -3.5, 0.75, 9.0, 4.0, -0.5)
    body += struct.pack("<HBB7d", 21, 0, 0, -1000.0, 2000.0, 40.0, 0.0, 0.0, 0.0, 0.0)
    return body


def client_datagrams():
    for i, (message_type, body) in enumerate(client_bodies()):
        yield b"TSUD" + struct.pack("<BBHIIII", 2, message_type, 0, 0xA0B0C0D0 + i, 0x01020304 + i, 0x10203040 + i,
                                    24 + len(body)) + body


for datagram in {"tracker": tracker_datagrams, "client": client_datagrams}[sys.argv[1]]():
    sys.stdout.buffer.write(struct.pack("<I", len(datagram)) + datagram)
