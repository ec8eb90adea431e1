"""The envelope of every message of the VR-OOS bus, and its encryption: docs/reference/bus_protocol.md."""

import dataclasses
import hmac
import os
import pathlib
import struct
import zlib

import xxhash
from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM

LATEST, STATE, EVENT, SERVICE, CONTROL, BULK = range(1, 7)
MAX_DATAGRAM_BYTES = 1200
MAX_STAMPS = 16

# Magic, version, class, part, parts, topic, digest, session, node, stamps of two traces, flags, boot, sequence, publish
# time, payload bytes, CRC-32, and two traces' id and origin.
HEAD = struct.Struct("<IBBBBIIQIBBHQQqIIQqQq")
MAGIC, VERSION, CRC_AT = 0x534F4F56, 1, 60
SEALED_BIT, HISTORY_MASK, SEAL_BYTES = 0x8000, 0x07FF, 24


def hash32(text):
    """Topic ids, node ids and schema digests: the low half of xxHash3."""
    return xxhash.xxh3_64_intdigest(text) & 0xFFFFFFFF


@dataclasses.dataclass
class Envelope:
    topic_class: int
    topic: int = 0
    digest: int = 0
    session: int = 0
    node: int = 0
    boot: int = 0
    sequence: int = 0
    publish_ns: int = 0
    part: int = 0
    parts: int = 1
    stamps: bytes = b""  # of both traces, as on the wire
    num_stamps: tuple = (0, 0)
    traces: tuple = (0, 0, 0, 0)  # id and origin of each
    history: bytes = b""  # earlier samples, behind the payload

    def write(self, payload, seal=None):
        """With a Sealer: encrypted."""
        e = self
        flags = len(e.history) | (SEALED_BIT if seal else 0)
        head = HEAD.pack(MAGIC, VERSION, e.topic_class, e.part, e.parts, e.topic, e.digest, e.session, e.node,
                         *e.num_stamps, flags, e.boot, e.sequence, e.publish_ns, len(payload), 0, *e.traces) + e.stamps
        if seal:
            return head + seal(e.topic_class, head, payload + e.history)
        rest = head[CRC_AT + 4:] + payload + e.history
        return head[:CRC_AT] + struct.pack("<I", zlib.crc32(rest, zlib.crc32(head[:CRC_AT]))) + rest


def is_latest(data):
    """Whether the class field says LATEST; the rest is not checked (read_envelope does that)."""
    return len(data) <= MAX_DATAGRAM_BYTES and data[:4] == b"VOOS" and data[5:6] == bytes([LATEST])


def read_envelope(data, unseal=None):
    """(Envelope, payload), or None if the bytes are no sound envelope. With `unseal`, (envelope, clear, body) -> bytes
    or None, only sealed messages are accepted; without it only those in the clear."""
    if len(data) < HEAD.size:
        return None
    (magic, version, topic_class, part, parts, topic, digest, session, node, direct, other, flags, boot, sequence,
     publish_ns, payload_bytes, crc, *traces) = HEAD.unpack_from(data)
    start, history = HEAD.size + 5 * (direct + other), flags & HISTORY_MASK
    if (magic != MAGIC or version != VERSION or not LATEST <= topic_class <= BULK or part >= parts
            or max(direct, other) > MAX_STAMPS or flags & ~HISTORY_MASK != (SEALED_BIT if unseal else 0)
            or len(data) != start + payload_bytes + history + (SEAL_BYTES if unseal else 0)):
        return None
    envelope = Envelope(topic_class, topic, digest, session, node, boot, sequence, publish_ns, part, parts,
                        data[HEAD.size:start], (direct, other), tuple(traces))
    if unseal:
        body = unseal(envelope, data[:start], data[start:])
        if body is None:
            return None
    elif zlib.crc32(data[CRC_AT + 4:], zlib.crc32(data[:CRC_AT])) == crc:
        body = data[start:]
    else:
        return None
    envelope.history = body[payload_bytes:]
    return envelope, body[:payload_bytes]


def sender_key(session_key, instance):
    """The key that seals one node's datagrams."""
    return hmac.digest(session_key, b"VR-OOS datagram" + struct.pack("<Q", instance), "sha256")


class Sealer:
    """Encrypts all behind an envelope's stamps and authenticates the whole; a counter keeps each nonce unique."""

    def __init__(self, key):
        self.cipher, self.counters = AESGCM(key), [0, 0]

    def __call__(self, topic_class, clear, body):
        channel = 0 if topic_class == LATEST else 1
        self.counters[channel] += 1
        sealed = self.cipher.encrypt(struct.pack("<IQ", channel, self.counters[channel]), body, clear)
        return sealed[:-16] + struct.pack("<Q", self.counters[channel]) + sealed[-16:]


class Opener:
    """Opens what one sender sealed. Accepts each counter once, and none older than 63 before the newest."""

    def __init__(self, key):
        self.cipher, self.newest, self.seen = AESGCM(key), [0, 0], [0, 0]

    def __call__(self, topic_class, clear, body):
        channel = 0 if topic_class == LATEST else 1
        (counter,) = struct.unpack_from("<Q", body, len(body) - 24)
        newest, seen = self.newest[channel], self.seen[channel]
        behind = newest - counter
        if counter == 0 or behind >= 64 or (behind >= 0 and seen >> behind & 1):
            return None
        try:
            opened = self.cipher.decrypt(struct.pack("<IQ", channel, counter), body[:-24] + body[-16:], clear)
        except InvalidTag:
            return None
        if counter > newest:
            self.newest[channel], seen, behind = counter, seen << min(counter - newest, 64) & (1 << 64) - 1, 0
        self.seen[channel] = seen | 1 << behind
        return opened


class Keys:
    """A member's CURVE keys and the keys it admits, from a run's key directory."""

    def __init__(self, directory, name):
        folder = pathlib.Path(directory)
        stem = name
        while not (folder / f"{stem}.key").exists():  # a key named K is for nodes called K or K-anything
            stem, dash, _ = stem.rpartition("-")
            if not dash:
                raise FileNotFoundError(f"no key for {name} in {folder}; name the node client-SOMETHING?")
        for path in (folder, folder / "allowed", folder / f"{stem}.key"):
            info = path.stat()
            if info.st_uid != os.geteuid():
                raise PermissionError(f"{path} belongs to user {info.st_uid}; take keys that user {os.geteuid()} made, "
                                      "or chown them")
            if info.st_mode & 0o077:
                raise PermissionError(f"{path} can be read by others; keys need chmod 700 (directory) and 600 (files)")
        self.public, self.secret = (line.encode() for line in (folder / f"{stem}.key").read_text().split())
        self.allowed = {key.encode(): owner for key, owner in
                        (line.split() for line in (folder / "allowed").read_text().splitlines())}
        self.registry = next(key for key, owner in self.allowed.items() if owner == "registry")
