// The envelope of every message of the bus: docs/reference/bus_protocol.md, "Envelope".

import { createXXHash3 } from "hash-wasm";

export const LATEST = 1, STATE = 2, EVENT = 3, SERVICE = 4, CONTROL = 5, BULK = 6;
export const MAX_DATAGRAM_BYTES = 1200;
const MAGIC = 0x534f4f56, VERSION = 1, HEAD_BYTES = 96, STAMP_BYTES = 5, MAX_STAMPS = 16, CRC_AT = 60;
const SEALED_BIT = 0x8000, HISTORY_MASK = 0x07ff, SEAL_BYTES = 24;

const xxh3 = await createXXHash3();

// Topic ids, node ids and schema digests: the low half of xxHash3.
export function hash32(text) {
  return parseInt(xxh3.init().update(text).digest().slice(-8), 16);
}

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let bit = 0; bit < 8; ++bit) n = n & 1 ? (n >>> 1) ^ 0xedb88320 : n >>> 1;
  return n >>> 0;
});

// CRC-32 as zlib's (node:zlib has it from version 22 on), of everything but the checksum itself.
function checksum(bytes) {
  let crc = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) {
    if (i === CRC_AT) i += 4;
    if (i < bytes.length) crc = CRC_TABLE[(crc ^ bytes[i]) & 0xff] ^ (crc >>> 8);
  }
  return (crc ^ 0xffffffff) >>> 0;
}

const NONE = Buffer.alloc(0);

// Required fields: topicClass, topic, digest, session, node, boot, sequence, publishNs. Optional: part (0), parts (1),
// stamps, numStamps, traces, history (none). 64-bit numbers are BigInts. `seal` encrypts all behind the stamps:
// (topicClass, clear, body) => Buffer.
export function writeEnvelope(e, payload, seal) {
  const { part = 0, parts = 1, numStamps = [0, 0], traces = [0n, 0n, 0n, 0n], stamps = NONE, history = NONE } = e;
  const head = Buffer.alloc(HEAD_BYTES);
  head.writeUInt32LE(MAGIC, 0);
  head.set([VERSION, e.topicClass, part, parts], 4);
  head.writeUInt32LE(e.topic, 8);
  head.writeUInt32LE(e.digest, 12);
  head.writeBigUInt64LE(e.session, 16);
  head.writeUInt32LE(e.node, 24);
  head.set(numStamps, 28);
  head.writeUInt16LE(history.length | (seal ? SEALED_BIT : 0), 30);
  head.writeBigUInt64LE(e.boot, 32);
  head.writeBigUInt64LE(e.sequence, 40);
  head.writeBigInt64LE(e.publishNs, 48);
  head.writeUInt32LE(payload.length, 56);
  for (const i of [0, 2]) {
    head.writeBigUInt64LE(traces[i], 64 + 8 * i);
    head.writeBigInt64LE(traces[i + 1], 72 + 8 * i);
  }
  if (seal) {
    const clear = Buffer.concat([head, stamps]);
    return Buffer.concat([clear, seal(e.topicClass, clear, Buffer.concat([payload, history]))]);
  }
  const bytes = Buffer.concat([head, stamps, payload, history]);
  bytes.writeUInt32LE(checksum(bytes), CRC_AT);
  return bytes;
}

// Whether the class field says LATEST; the rest is not checked (readEnvelope does that).
export function isLatest(data) {
  return data.length <= MAX_DATAGRAM_BYTES && data.toString("latin1", 0, 4) === "VOOS" && data[5] === LATEST;
}

// {envelope, payload}, or null if the bytes are no sound envelope. With `unseal` ((envelope, clear, body) => Buffer or
// null) only sealed messages are accepted; without it only those in the clear.
export function readEnvelope(data, unseal) {
  const bytes = Buffer.from(data.buffer, data.byteOffset, data.length);
  if (bytes.length < HEAD_BYTES || bytes.readUInt32LE(0) !== MAGIC || bytes[4] !== VERSION) return null;
  const [topicClass, part, parts] = bytes.subarray(5, 8);
  const numStamps = [...bytes.subarray(28, 30)];
  const flags = bytes.readUInt16LE(30);
  const start = HEAD_BYTES + STAMP_BYTES * (numStamps[0] + numStamps[1]);
  const payloadBytes = bytes.readUInt32LE(56);
  const size = start + payloadBytes + (flags & HISTORY_MASK) + (unseal ? SEAL_BYTES : 0);
  if (topicClass < LATEST || topicClass > BULK || part >= parts || Math.max(...numStamps) > MAX_STAMPS ||
      (flags & ~HISTORY_MASK) !== (unseal ? SEALED_BIT : 0) || bytes.length !== size) {
    return null;
  }
  const envelope = {
    topicClass, part, parts, numStamps,
    topic: bytes.readUInt32LE(8),
    digest: bytes.readUInt32LE(12),
    session: bytes.readBigUInt64LE(16),
    node: bytes.readUInt32LE(24),
    boot: bytes.readBigUInt64LE(32),
    sequence: bytes.readBigUInt64LE(40),
    publishNs: bytes.readBigInt64LE(48),
    traces: [64, 72, 80, 88].map((at) => (at % 16 ? bytes.readBigInt64LE(at) : bytes.readBigUInt64LE(at))),
    stamps: bytes.subarray(HEAD_BYTES, start),
  };
  if (!unseal && bytes.readUInt32LE(CRC_AT) !== checksum(bytes)) return null;
  const body = unseal ? unseal(envelope, bytes.subarray(0, start), bytes.subarray(start)) : bytes.subarray(start);
  if (!body) return null;
  envelope.history = body.subarray(payloadBytes);
  return { envelope, payload: body.subarray(0, payloadBytes) };
}
