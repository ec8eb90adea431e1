// The cases of MCAP's conformance suite: six inputs under every combination of optional features that makes sense for
// them, built with @mcap/core's record builder. 416 in all.
import { McapRecordBuilder, McapChunkBuilder } from "@mcap/core";
import { crc32 } from "@foxglove/crc";

export const kFeatures = ["ch", "mx", "st", "rsh", "rch", "ax", "mdx", "chx", "sum", "pad"];
// What our writer always does; records are never padded.
export const kWriterFeatures = new Set(kFeatures.filter((feature) => feature !== "pad"));

const kSchema = { type: "Schema", id: 1, name: "Example", encoding: "c", data: new Uint8Array([4, 5, 6]) };
const Channel = (id, schemaId) =>
  ({ type: "Channel", id, schemaId, topic: "example", messageEncoding: "a", metadata: new Map([["foo", "bar"]]) });
const Message = (channelId, sequence, time, publishTime = time) =>
  ({ type: "Message", channelId, sequence, logTime: BigInt(time), publishTime: BigInt(publishTime),
     data: new Uint8Array([1, 2, 3]) });
const kTimes = [0, 2, 1, 3, 3, 5, 4, 7, 8, 9];  // out of order, and two at once

// Channels count from `firstChannel`.
export function Inputs(firstChannel) {
  const c = firstChannel;
  return {
    NoData: [],
    OneAttachment: [{ type: "Attachment", name: "myFile", mediaType: "application/octet-stream", createTime: 1n,
                      logTime: 2n, data: new Uint8Array([1, 2, 3]) }],
    OneMessage: [kSchema, Channel(c, 1), Message(c, 10, 2, 1)],
    OneMetadata: [{ type: "Metadata", name: "myMetadata", metadata: new Map([["foo", "bar"]]) }],
    OneSchemalessMessage: [Channel(c, 0), Message(c, 10, 2, 1)],
    TenMessages: [kSchema, Channel(c, 1), ...kTimes.map((time, i) => Message(c, i, time))],
  };
}

function MakesSense(features, records) {
  const has = (...types) => records.some((record) => types.includes(record.type));
  const uses = (feature) => features.has(feature);
  if (uses("ax") && !has("Attachment")) return false;
  if (uses("mdx") && !has("Metadata")) return false;
  if (uses("rsh") && !has("Schema")) return false;
  if (uses("rch") && !has("Channel")) return false;
  if (uses("ch") && !has("Message", "Channel", "Schema")) return false;
  if ((uses("mx") || uses("chx")) && !uses("ch")) return false;
  if (uses("sum") && !["chx", "rsh", "rch", "mdx", "ax", "st"].some(uses)) return false;
  return true;
}

export function* Variants(firstChannel = 1) {
  for (const [name, records] of Object.entries(Inputs(firstChannel))) {
    for (let bits = 0; bits < 1 << kFeatures.length; ++bits) {
      const features = new Set(kFeatures.filter((_, i) => (bits >> i) & 1));
      if (MakesSense(features, records)) yield { name: [name, ...[...features].sort()].join("-"), features, records };
    }
  }
}

// {bytes, expected}: the file, and its records as a streamed reader finds them. "Flush" among the records ends a chunk.
export function Build(features, records) {
  const builder = new McapRecordBuilder({ padRecords: features.has("pad") });
  const expected = [];
  // Writes a record; returns its offset and length in bytes.
  const put = (type, content) => {
    const offset = BigInt(builder.length);
    builder[`write${type}`](content);
    if (!["Chunk", "MessageIndex"].includes(type)) expected.push({ ...content, type });
    return { offset, length: BigInt(builder.length) - offset };
  };
  builder.writeMagic();
  put("Header", { profile: "", library: "" });

  const statistics = { messageCount: 0n, schemaCount: 0, channelCount: 0, attachmentCount: 0, metadataCount: 0,
                       chunkCount: 0, messageStartTime: 0n, messageEndTime: 0n, channelMessageCounts: new Map() };
  const attachmentIndexes = [], metadataIndexes = [], chunkIndexes = [];
  const NewChunk = () => features.has("ch") ? new McapChunkBuilder({ useMessageIndex: features.has("mx") }) : undefined;
  let chunk = NewChunk();
  const closeChunk = () => {
    if (!chunk || chunk.byteLength === 0) return;
    ++statistics.chunkCount;
    const { offset, length } = put("Chunk", {
      messageStartTime: chunk.messageStartTime, messageEndTime: chunk.messageEndTime, compression: "",
      uncompressedSize: BigInt(chunk.byteLength), uncompressedCrc: crc32(chunk.buffer), records: chunk.buffer });
    const messageIndexOffsets = new Map();
    let messageIndexLength = 0n;
    for (const index of chunk.indices) {
      if (index.records.length === 0) continue;
      const placed = put("MessageIndex", index);
      messageIndexOffsets.set(index.channelId, placed.offset);
      messageIndexLength += placed.length;
    }
    chunkIndexes.push({
      messageStartTime: chunk.messageStartTime, messageEndTime: chunk.messageEndTime, chunkStartOffset: offset,
      chunkLength: length, messageIndexOffsets, messageIndexLength, compression: "",
      compressedSize: BigInt(chunk.byteLength), uncompressedSize: BigInt(chunk.byteLength) });
    chunk = NewChunk();
  };

  for (const record of records) {
    switch (record.type) {
      case "Schema":
      case "Channel":
        ++statistics[record.type === "Schema" ? "schemaCount" : "channelCount"];
        if (chunk) { chunk[`add${record.type}`](record); expected.push(record); } else put(record.type, record);
        break;
      case "Message": {
        const { messageCount, messageStartTime, messageEndTime, channelMessageCounts } = statistics;
        const isFirst = messageCount === 0n;
        statistics.messageStartTime = isFirst || record.logTime < messageStartTime ? record.logTime : messageStartTime;
        statistics.messageEndTime = isFirst || record.logTime > messageEndTime ? record.logTime : messageEndTime;
        statistics.messageCount = messageCount + 1n;
        channelMessageCounts.set(record.channelId, (channelMessageCounts.get(record.channelId) ?? 0n) + 1n);
        if (chunk) { chunk.addMessage(record); expected.push(record); } else put("Message", record);
        break;
      }
      case "Attachment": {
        closeChunk();
        ++statistics.attachmentCount;
        const { name, mediaType, logTime, createTime } = record;
        const dataSize = BigInt(record.data.byteLength);
        attachmentIndexes.push({ ...put("Attachment", record), name, mediaType, logTime, createTime, dataSize });
        break;
      }
      case "Metadata":
        closeChunk();
        ++statistics.metadataCount;
        metadataIndexes.push({ ...put("Metadata", record), name: record.name });
        break;
      case "Flush":
        closeChunk();
        break;
    }
  }
  closeChunk();
  put("DataEnd", { dataSectionCrc: crc32(builder.buffer) });

  const summaryStart = BigInt(builder.length);
  const offsets = [];
  const group = (feature, groupOpcode, type, contents) => {
    const groupStart = BigInt(builder.length);
    if (features.has(feature)) for (const content of contents) put(type, content);
    const groupLength = BigInt(builder.length) - groupStart;
    if (groupLength !== 0n) offsets.push({ groupOpcode, groupStart, groupLength });
  };
  const ofType = (type) => records.filter((record) => record.type === type);
  group("rsh", 0x03, "Schema", ofType("Schema"));
  group("rch", 0x04, "Channel", ofType("Channel"));
  group("st", 0x0b, "Statistics", [statistics]);
  group("mdx", 0x0d, "MetadataIndex", metadataIndexes);
  group("ax", 0x0a, "AttachmentIndex", attachmentIndexes);
  group("chx", 0x08, "ChunkIndex", chunkIndexes);
  const hasSummary = BigInt(builder.length) !== summaryStart;
  let summaryOffsetStart = 0n;
  if (features.has("sum")) {
    summaryOffsetStart = BigInt(builder.length);
    for (const offset of offsets) put("SummaryOffset", offset);
  }
  // The checksum covers the summary and the footer up to itself.
  const footer = { summaryStart: hasSummary ? summaryStart : 0n, summaryOffsetStart, summaryCrc: 0 };
  const probe = new McapRecordBuilder();
  probe.writeFooter(footer);
  const summary = builder.buffer.slice(Number(summaryStart));
  footer.summaryCrc = crc32(Buffer.concat([summary, probe.buffer.slice(0, probe.length - 4)]));
  put("Footer", footer);
  builder.writeMagic();
  return { bytes: builder.buffer.slice(), expected };
}

const SnakeCase = (name) => name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
function Value(value) {
  if (value instanceof Uint8Array) return Array.from(value, String);
  if (value instanceof Map) return Object.fromEntries([...value].map(([key, item]) => [String(key), Value(item)]));
  return typeof value === "bigint" || typeof value === "number" ? String(value) : value;
}

// {type, fields} with every number as a text: no number of 64 bits is rounded.
export function Plain({ type, ...fields }) {
  return { type, fields: Object.fromEntries(Object.entries(fields).map(([key, v]) => [SnakeCase(key), Value(v)])) };
}

// The expected output of an indexed reader for these records.
export function PlainIndexed(expected) {
  const messages = expected.filter((record) => record.type === "Message");
  messages.sort((a, b) => (a.logTime < b.logTime ? -1 : a.logTime > b.logTime ? 1 : 0));  // stable
  const byId = (type) => [...new Map(expected.filter((r) => r.type === type).map((r) => [r.id, r])).values()];
  return {
    schemas: byId("Schema").map(Plain),
    channels: byId("Channel").map(Plain),
    messages: messages.map(Plain),
    statistics: expected.filter((record) => record.type === "Statistics").map(Plain),
  };
}
