// Topics of the bus, their message types, and the types' shapes. The types come from the descriptors that protoc makes
// of the repository's proto/: in the folder that OOS_STUBS names, or where `./dev build` puts them.

import { readFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { ScalarType, create, createFileRegistry, fromBinary } from "@bufbuild/protobuf";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt";
import { hash32 } from "./envelope.mjs";

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
const STUBS = process.env.OOS_STUBS ?? path.join(ROOT, "build/release/clients/stubs");
export const descriptors = fromBinary(FileDescriptorSetSchema, readFileSync(path.join(STUBS, "oos.desc")));
const types = createFileRegistry(descriptors);
export const typeOf = (name) => types.getMessage(name);

const RULES = JSON.parse(readFileSync(path.join(ROOT, "clients/topics.json"), "utf8")).rules;

const found = new Map();

// The first line of topics.json that matches, if one does.
export function findRule(topic) {
  if (!found.has(topic)) found.set(topic, RULES.find((one) => matches(one.pattern, topic)));
  return found.get(topic);
}

export function ruleOf(topic) {
  const rule = findRule(topic);
  if (!rule) throw new Error(`no rule in clients/topics.json matches topic '${topic}'`);
  return rule;
}

// A message of the topic's type, with the fields given: message("device/right/state", {isEngaged: true}).
export const message = (topic, fields) => create(typeOf(ruleOf(topic).type), fields);

// The message that was sent in parts: lists joined in order, the rest as in the first part.
export function mergeParts(type, parts) {
  for (const field of type.fields.filter((one) => one.fieldKind === "list")) {
    for (const part of parts.slice(1)) parts[0][field.localName].push(...part[field.localName]);
  }
  return parts[0];
}

// The shape of a message type, whose hash is its schema digest: "1:uint64 6:repeated_uint32 7:{1:float}".
export function canonical(message) {
  return [...message.fields].sort((a, b) => a.number - b.number).map((field) => {
    const list = field.fieldKind === "list" ? "repeated_" : "";
    const kind = field.message ? `{${canonical(field.message)}}` : ScalarType[field.scalar].toLowerCase();
    return `${field.number}:${list}${kind}`;
  }).join(" ");
}

const digests = new Map();

// A message type's schema digest.
export function digestOf(type) {
  if (!digests.has(type)) digests.set(type, hash32(canonical(type)));
  return digests.get(type);
}

// '*' stands for any text, slashes included; every other character for itself.
export function matches(pattern, text) {
  const escaped = pattern.split("*").map((piece) => piece.replace(/[.+?^${}()|[\]\\]/g, "\\$&"));
  return new RegExp(`^${escaped.join(".*")}$`, "s").test(text);
}
