"""A peer that knows only protocol/README.md: seals and opens datagrams, and makes address cookies. Its cipher is written
from draft-irtf-cfrg-xchacha-03 and RFC 8439 in plain Python, and shares no line with libsodium.

seal_peer.py check                                  the cipher against appendix A.3.1 of the draft
seal_peer.py id KEY
seal_peer.py seal KEY LABEL KIND SESSION PEER COUNTER PAYLOAD...   (- for no payload)  a datagram for each payload
seal_peer.py open KEY LABEL DATAGRAM                KIND SESSION PEER COUNTER PAYLOAD
seal_peer.py cookie SECRET IP PORT EPOCH

Bytes are hexadecimal digits, here and in what is printed."""

import hashlib
import struct
import sys

MASK = 0xFFFFFFFF


def quarter_round(x, a, b, c, d):
    for first, second, third, bits in ((a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)):
        x[first] = (x[first] + x[second]) & MASK
        x[third] ^= x[first]
        x[third] = ((x[third] << bits) | (x[third] >> (32 - bits))) & MASK


def rounds(state):
    x = list(state)
    for _ in range(10):
        for a in range(4):
            quarter_round(x, a, a + 4, a + 8, a + 12)
        for a in range(4):
            quarter_round(x, a, 4 + (a + 1) % 4, 8 + (a + 2) % 4, 12 + (a + 3) % 4)
    return x


CONSTANTS = struct.unpack("<4I", b"expand 32-byte k")


def hchacha20(key, nonce16):
    x = rounds(CONSTANTS + struct.unpack("<8I", key) + struct.unpack("<4I", nonce16))
    return struct.pack("<8I", *x[:4], *x[12:])


def chacha20(key, first_block, nonce12, text):
    out = bytearray()
    for i in range(0, len(text), 64):
        state = CONSTANTS + struct.unpack("<8I", key) + (first_block + i // 64,) + struct.unpack("<3I", nonce12)
        block = struct.pack("<16I", *((a + b) & MASK for a, b in zip(state, rounds(state))))
        out += bytes(a ^ b for a, b in zip(text[i:i + 64], block))
    return bytes(out)


def poly1305(key, message):
    r = int.from_bytes(key[:16], "little") & 0x0FFFFFFC0FFFFFFC0FFFFFFC0FFFFFFF
    total = 0
    for i in range(0, len(message), 16):
        total = (total + int.from_bytes(message[i:i + 16] + b"\1", "little")) * r % (2**130 - 5)
    return ((total + int.from_bytes(key[16:32], "little")) % 2**128).to_bytes(16, "little")


def tag_of(key, nonce12, associated, ciphertext):
    def padded(text):
        return text + bytes(-len(text) % 16)
    return poly1305(chacha20(key, 0, nonce12, bytes(32)),
                    padded(associated) + padded(ciphertext) + struct.pack("<QQ", len(associated), len(ciphertext)))


def encrypt(key, nonce24, associated, text):
    inner, nonce12 = hchacha20(key, nonce24[:16]), bytes(4) + nonce24[16:]
    ciphertext = chacha20(inner, 1, nonce12, text)
    return ciphertext + tag_of(inner, nonce12, associated, ciphertext)


def decrypt(key, nonce24, associated, sealed):
    inner, nonce12 = hchacha20(key, nonce24[:16]), bytes(4) + nonce24[16:]
    ciphertext, tag = sealed[:-16], sealed[-16:]
    if tag_of(inner, nonce12, associated, ciphertext) != tag:
        sys.exit("the tag is wrong")
    return chacha20(inner, 1, nonce12, ciphertext)


def check():
    key, nonce = bytes(range(0x80, 0xA0)), bytes(range(0x40, 0x58))
    associated = bytes.fromhex("50515253c0c1c2c3c4c5c6c7")
    text = (b"Ladies and Gentlemen of the class of '99: If I could offer you only one tip for the future, sunscreen "
            b"would be it.")
    sealed = bytes.fromhex(
        "bd6d179d3e83d43b9576579493c0e939572a1700252bfaccbed2902c21396cbb731c7f1b0b4aa6440bf3a82f4eda7e39"
        "ae64c6708c54c216cb96b72e1213b4522f8c9ba40db5d945b11b69b982c1bb9e3f3fac2bc369488f76b2383565d3fff9"
        "21f9664c97637da9768812f615c68b13b52ec0875924c1c7987947deafd8780acf49")
    if encrypt(key, nonce, associated, text) != sealed or decrypt(key, nonce, associated, sealed) != text:
        sys.exit("the cipher is not that of the draft")
    print("ok")


def key_id(key):
    return hashlib.blake2b(key, digest_size=32).digest()[:8]


def key_of(key, label):
    return hashlib.blake2b(label.encode("ascii"), digest_size=32, key=key).digest()


def seal(key, label, kind, session, peer, counter, payload):
    header = b"TSEA" + struct.pack("<BBH", 1, kind, 0) + key_id(key) + session + peer + struct.pack("<Q", counter)
    return header + encrypt(key_of(key, label), session + struct.pack("<Q", counter), header, payload)


def unseal(key, label, datagram):
    magic, version, kind, reserved, name, session, peer, counter = struct.unpack_from("<4sBBH8s16s16sQ", datagram)
    if (magic, version, reserved, name) != (b"TSEA", 1, 0, key_id(key)):
        sys.exit("the header is wrong")
    payload = decrypt(key_of(key, label), session + struct.pack("<Q", counter), datagram[:56], datagram[56:])
    return kind, session, peer, counter, payload


def cookie(secret, ip, port, epoch):
    return hashlib.blake2b(ip + struct.pack("<HQ", port, epoch), digest_size=16, key=secret).digest()


def main(command, *words):
    of_hex = bytes.fromhex
    if command == "check":
        check()
    elif command == "id":
        print(key_id(of_hex(words[0])).hex())
    elif command == "seal":
        key, label, kind, session, peer, counter, *payloads = words
        for payload in payloads:
            text = b"" if payload == "-" else of_hex(payload)
            print(seal(of_hex(key), label, int(kind), of_hex(session), of_hex(peer), int(counter), text).hex())
    elif command == "open":
        kind, session, peer, counter, payload = unseal(of_hex(words[0]), words[1], of_hex(words[2]))
        print(kind, session.hex(), peer.hex(), counter, payload.hex() or "-")
    elif command == "cookie":
        print(cookie(of_hex(words[0]), of_hex(words[1]), int(words[2]), int(words[3])).hex())


main(*sys.argv[1:])
