// Keys, the list of allowed members, and sealed datagrams: docs/reference/bus_protocol.md, "Security".

import { createCipheriv, createDecipheriv, createHmac } from "node:crypto";
import { existsSync, readFileSync, statSync } from "node:fs";
import path from "node:path";
import { LATEST } from "./envelope.mjs";

const TAG_BYTES = 16, COUNTER_BYTES = 8;
const channelOf = (topicClass) => (topicClass === LATEST ? 0 : 1);

function nonceOf(channel, counter) {
  const nonce = Buffer.alloc(12);
  nonce.writeUInt32LE(channel, 0);
  nonce.writeBigUInt64LE(counter, 4);
  return nonce;
}

// The key that seals one node's datagrams.
export function senderKey(sessionKey, instance) {
  const number = Buffer.alloc(8);
  number.writeBigUInt64LE(instance);
  return createHmac("sha256", sessionKey).update("VR-OOS datagram").update(number).digest();
}

// The `seal` of writeEnvelope: encrypts all behind an envelope's stamps and authenticates the whole; a counter keeps each
// nonce unique.
export function makeSealer(key, counters = [0n, 0n]) {
  return (topicClass, clear, body) => {
    const channel = channelOf(topicClass);
    const nonce = nonceOf(channel, ++counters[channel]);
    const cipher = createCipheriv("aes-256-gcm", key, nonce, { authTagLength: TAG_BYTES });
    cipher.setAAD(clear, { plaintextLength: body.length });
    return Buffer.concat([cipher.update(body), cipher.final(), nonce.subarray(4), cipher.getAuthTag()]);
  };
}

// The `unseal` of readEnvelope, for one sender. Accepts each counter once, and none older than 63 before the newest.
export function makeOpener(key) {
  const windows = [{ newest: 0n, seen: 0n }, { newest: 0n, seen: 0n }];
  return (topicClass, clear, sealed) => {
    const end = sealed.length - COUNTER_BYTES - TAG_BYTES;
    const counter = sealed.readBigUInt64LE(end);
    const window = windows[channelOf(topicClass)];
    const behind = window.newest - counter;
    if (counter === 0n || behind >= 64n || (behind >= 0n && (window.seen >> behind) & 1n)) return null;
    const decipher = createDecipheriv("aes-256-gcm", key, nonceOf(channelOf(topicClass), counter),
      { authTagLength: TAG_BYTES });
    decipher.setAAD(clear, { plaintextLength: end });
    decipher.setAuthTag(sealed.subarray(end + COUNTER_BYTES));
    let body;
    try {
      body = Buffer.concat([decipher.update(sealed.subarray(0, end)), decipher.final()]);
    } catch {  // not authentic
      return null;
    }
    if (behind < 0n) {
      window.seen = -behind < 64n ? BigInt.asUintN(64, window.seen << -behind) : 0n;
      window.newest = counter;
    }
    window.seen |= 1n << (window.newest - counter);
    return body;
  };
}

// A member's CURVE keys and the keys it admits, from a run's key directory.
export function loadKeys(directory, name) {
  let stem = name;
  while (!existsSync(path.join(directory, `${stem}.key`))) {  // a key named K is for nodes called K or K-anything
    const dash = stem.lastIndexOf("-");
    if (dash < 0) throw new Error(`no key for ${name} in ${directory}; name the node client-SOMETHING?`);
    stem = stem.slice(0, dash);
  }
  const files = [directory, path.join(directory, "allowed"), path.join(directory, `${stem}.key`)];
  for (const file of files) {
    const { uid, mode } = statSync(file);
    if (uid !== process.geteuid()) {
      throw new Error(`${file} belongs to user ${uid}; take keys that user ${process.geteuid()} made, or chown them`);
    }
    if (mode & 0o077) {
      throw new Error(`${file} can be read by others; keys need chmod 700 (directory) and 600 (files)`);
    }
  }
  const [publicKey, secretKey] = readFileSync(files[2], "utf8").split("\n");
  const allowed = new Map(readFileSync(files[1], "utf8").trim().split("\n").map((line) => line.split(" ")));
  const [registryKey] = [...allowed].find(([, owner]) => owner === "registry");
  return { publicKey, secretKey, allowed, registryKey };
}

const Z85 = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";

// As text, the way keys are written [ZeroMQ RFC 32]: five digits to the base of 85 for four bytes.
export function z85(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 4) {
    let value = bytes.readUInt32BE(i), digits = "";
    for (let digit = 0; digit < 5; ++digit, value = Math.floor(value / 85)) digits = Z85[value % 85] + digits;
    text += digits;
  }
  return text;
}
