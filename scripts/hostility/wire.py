"""Datagrams and recordings by protocol/README.md, packed and read here: a peer that shares no code with the daemon."""
import struct

CLIENT_TYPES = {"hello": 0x01, "query_names": 0x02, "query_targets": 0x03, "query_mesh": 0x04, "query_topology": 0x05, "query_status": 0x06,
                "subscribe": 0x07, "unsubscribe": 0x08, "query_probes": 0x09, "prove_address": 0x0A}
BODIES = {"hello": b"intruder".ljust(24, b"\0"), "query_names": b"\0", "query_mesh": b"\x04", "query_topology": b"\x04",
          "subscribe": struct.pack("<BBHd", 15, 4, 3600, 0.0), "prove_address": bytes(16)}


def client_message(kind, sequence, body=None):
    body = BODIES.get(kind, b"") if body is None else body
    return b"TSUD" + struct.pack("<BBHIIII", 2, CLIENT_TYPES[kind], 0, 0xBAD, sequence, 0, 24 + len(body)) + body


def name(text):
    return text.encode().ljust(24, b"\0")


def tracker_frame(number, pads=(), markers=(), stamp_ns=None):
    """pads: (name, (x, y, z)); markers: likewise."""
    items = [] if stamp_ns is None else [struct.pack("<BHQBB", 0x54, 10, stamp_ns, 0, 1)]
    items += [struct.pack("<BH", 0, 72) + name(pad) + struct.pack("<6d", *place, 0, 0, 0) for pad, place in pads]
    items += [struct.pack("<BH", 0x4D, 49) + name(marker) + struct.pack("<3dB", *place, 0) for marker, place in markers]
    return struct.pack("<IB", number % 2**32, len(items)) + b"".join(items)


def spoofed(source, destination, payload):
    """An IPv4 packet for a raw socket: from whom it likes. Without a UDP checksum, which IPv4 allows."""
    udp = struct.pack(">HHHH", source[1], destination[1], 8 + len(payload), 0) + payload
    address = [bytes(map(int, host.split("."))) for host, _ in (source, destination)]
    return struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, *address) + udp


def records(path):
    """(kind, stamp ns, body) of every whole record, and the bytes behind the last."""
    with open(path, "rb") as source:
        content = source.read()
    place, found = 1128, []
    while place + 24 <= len(content) and content[place:place + 4] == b"\xd5REC":
        size, kind = struct.unpack_from("<IB", content, place + 4)
        if place + 24 + size > len(content):
            break
        found.append((kind, struct.unpack_from("<Q", content, place + 12)[0], content[place + 20:place + 20 + size]))
        place += 24 + size
    return found, len(content) - place
