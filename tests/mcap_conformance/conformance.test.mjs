// node --test; MCAP_DRIVER names the built mcap_driver, WORK_DIR a folder to write to.
import { test } from "node:test";
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { McapStreamReader } from "@mcap/core";
import { Build, Inputs, Plain, PlainIndexed, Variants, kWriterFeatures } from "./cases.mjs";

const driver = process.env.MCAP_DRIVER;
const folder = join(process.env.WORK_DIR, "conformance");
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });

const cases = [...Variants()].map((variant) => {
  const path = join(folder, `${variant.name}.mcap`);
  const built = Build(variant.features, variant.records);
  writeFileSync(path, built.bytes);
  return { ...variant, ...built, path };
});
const lines = (mode) =>
  execFileSync(driver, [mode, ...cases.map(({ path }) => path)], { maxBuffer: 1 << 28 }).toString().trim().split("\n")
    .map((line) => JSON.parse(line));

test("there are 416 cases, and the reference reader finds in them what was put in", () => {
  assert.equal(cases.length, 416);
  for (const { bytes, expected, name } of cases) {
    const reader = new McapStreamReader({ validateCrcs: true });
    reader.append(bytes);
    const records = [];
    for (let record; (record = reader.nextRecord()); ) if (record.type !== "MessageIndex") records.push(Plain(record));
    assert.ok(reader.done(), name);
    assert.deepEqual(records, expected.map(Plain), name);
  }
});

test("the checksums are those of the published suite", () => {
  const { expected } = cases.find(({ name }) => name === "TenMessages-ch-chx-mx-rch-rsh-st-sum");
  assert.equal(expected.find(({ type }) => type === "DataEnd").dataSectionCrc, 2749581515);
  assert.equal(expected.find(({ type }) => type === "Footer").summaryCrc, 2261599816);
});

test("our streamed reader agrees on all 416", () => {
  const found = lines("streamed");
  assert.equal(found.length, cases.length);
  cases.forEach(({ expected, name }, i) => assert.deepEqual(found[i].records, expected.map(Plain), name));
});

test("our indexed reader agrees on all 416", () => {
  const found = lines("indexed");
  assert.equal(found.length, cases.length);
  cases.forEach(({ expected, name }, i) => assert.deepEqual(found[i], PlainIndexed(expected), name));
});

// Our writer has no options. Files differ only in their records and in where chunks end. So each input is written in one
// piece and with a flush between any two records, and all inputs are written one after another into one file.
test("our writer gives the same bytes as the builder", () => {
  const inputs = Inputs(0);
  const everything = [...inputs.OneMetadata, ...inputs.TenMessages, { type: "Flush" }, ...inputs.OneAttachment,
                      { ...inputs.OneSchemalessMessage[0], id: 1 }, { ...inputs.OneSchemalessMessage[1], channelId: 1 },
                      ...inputs.OneMetadata, { ...inputs.OneMessage[2], logTime: 20n }, ...inputs.OneAttachment];
  const flushed = (records) => records.flatMap((record) =>
    record.type === "Message" ? [record, { type: "Flush" }] : [record]);
  const written = Object.entries({ ...inputs, Everything: everything })
    .flatMap(([name, records]) => [[name, records], [`${name}-flushed`, flushed(records)]]);
  for (const [name, records] of written) {
    const path = join(folder, `written-${name}.mcap`);
    execFileSync(driver, ["write", path], { input: JSON.stringify(records.map(Plain)) });
    assert.ok(readFileSync(path).equals(Buffer.from(Build(kWriterFeatures, records).bytes)), name);
  }
});
