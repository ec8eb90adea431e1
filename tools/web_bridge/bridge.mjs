// Shows a session or a recording to web browsers (a page of its own) and to Foxglove or Lichtblick (foxglove.websocket.v1).
// It joins the bus as an observer; it writes only what a person at the page asks for. See README.md.

import { execFileSync } from "node:child_process";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { LATEST, findRule, ruleOf } from "../../clients/javascript/oos_bus.mjs";
import { Access, viewerKey } from "./access.mjs";
import { SceneServer } from "./foxglove_server.mjs";
import { PageServer } from "./page_server.mjs";
import { Recording } from "./recording.mjs";
import { Scene } from "./scene.mjs";
import { Session } from "./session.mjs";
import { Status } from "./status.mjs";

const USAGE = `usage: node bridge.mjs SCENARIO [options]
  --recording FILE.mcap             show this recording, in place of a session
  --registry ENDPOINT --session N   the session to show; default: the one running on this machine, now or later
  --keys DIR                        with --registry: the session's key directory; default: not encrypted
  --bind ADDRESS                    IPv4 address of its ends of the bus; default: 127.0.0.1
  --name NAME                       of its viewer on the bus; default: visual_node-web-<process>
  --view NAME                       the printed address stays with that camera
  --host ADDRESS                    address to serve on; default: 127.0.0.1 (this machine only)
  --port N                          port of the page and of Foxglove; default: 8765
  --programs DIR                    where oos and scene_stream are; default: build/release/bin
  --topics PATTERNS                 topics to show, separated by commas; default: *
`;

const APPLY_HZ = 30, STATUS_HZ = 10, FORCE_HZ = 50;
const ANSWER_MS = 10_000;  // a person waits for a busy machine longer than a program does
const STRING = { type: "string" };
const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");

function readArguments() {
  const { values, positionals } = parseArgs({ allowPositionals: true, options: {
    recording: STRING, registry: STRING, session: STRING, keys: STRING, help: { type: "boolean" },
    bind: { ...STRING, default: "127.0.0.1" }, name: { ...STRING, default: `visual_node-web-${process.pid}` }, view: STRING,
    host: { ...STRING, default: "127.0.0.1" }, port: { ...STRING, default: "8765" },
    programs: { ...STRING, default: path.join(ROOT, "build/release/bin") }, topics: { ...STRING, default: "*" } } });
  if (values.help || positionals.length !== 1) {
    console.error(USAGE);
    process.exit(values.help ? 0 : 2);
  }
  const fixed = values.registry
    ? { registry: values.registry, session: BigInt(values.session ?? 0), keys: values.keys ?? null, bind: values.bind } : null;
  return { ...values, fixed, scenario: positionals[0],
    programs: { oos: path.join(values.programs, "oos"), sceneStream: path.join(values.programs, "scene_stream") } };
}

function makeShown(wanted) {
  const { scenario, programs, recording, topics, fixed, name } = wanted;
  return recording ? new Recording({ scenario, programs, file: recording })
    : new Session({ scenario, programs, topics: topics.split(","), fixed, name });
}

// A parameter of a node is called NODE.NAME; those of "scene" choose what the page shows.
async function setParameter(shown, path, value) {
  const dot = path.indexOf(".");
  const [owner, name] = [path.slice(0, dot), path.slice(dot + 1)];
  if (dot < 1 || !Number.isFinite(value)) throw new Error("a parameter is NODE.NAME, its value a number");
  if (owner === "scene") shown.source?.say(`set ${name} ${value}`);
  else if (shown.node) await shown.node.setParameter(owner, name, value, { timeoutMs: ANSWER_MS });
  else throw new Error("no session runs");
}

// What a person at a page does with a hand: the numbers of scene_stream's command.
function steer(shown, numbers) {
  if (!Array.isArray(numbers) || !numbers.every(Number.isFinite)) throw new Error("a hand's input is a list of numbers");
  shown.source?.say(`hand ${numbers.join(" ")}`);
  return {};
}

function servicesOf(shown) {
  const services = { "/session/start": async () => shown.start(), "/session/stop": async () => shown.stop(),
    "/hand": async ({ numbers }) => steer(shown, numbers),
    "/clock": async () => ({ now_ms: performance.timeOrigin + performance.now() }) };
  if (!(shown instanceof Recording)) return services;
  return { "/clock": services["/clock"],
    "/recording/control": async ({ command, value }) => shown.control(command, value) };
}

async function main() {
  const wanted = readArguments();
  const description = JSON.parse(execFileSync(wanted.programs.oos, ["check", "--json", wanted.scenario],
    { encoding: "utf8", maxBuffer: 1 << 28 }));
  const shown = makeShown(wanted);
  const scene = new Scene(description);
  const status = new Status(description);
  const key = viewerKey(wanted.recording ? null : shown.find());
  const access = new Access(key);
  const page = new PageServer({ access, host: wanted.host, port: Number(wanted.port), secret: {
    assets: () => shown.source?.assets && { type: "application/x-protobuf", encoding: "gzip", bytes: shown.source.assets },
    block: (number) => shown.source?.blocks.has(Number(number)) &&
      { type: "application/octet-stream", bytes: shown.source.blocks.get(Number(number)) } } });
  await page.listening();
  const foxglove = new SceneServer({ name: `VR-OOS ${description.name}`, scene, http: page.http, access,
    services: servicesOf(shown), setParameter: (name, value) => setParameter(shown, name, value) });

  foxglove.announce("event", "oos.Event");
  // LATEST messages arrive at 1 kHz; the newest of each topic is applied at APPLY_HZ.
  const newest = new Map();
  const take = (message) => {
    try {
      status.apply(message);
      if (scene.apply(message)) foxglove.sendMeshes();
    } catch (error) {
      console.error(`web_bridge: ${message.topic} of ${message.writer}: ${error.message}`);
    }
  };
  const every = (hz, work) => setInterval(work, 1000 / hz);
  const timers = [
    every(APPLY_HZ, () => {
      newest.forEach(take);
      newest.clear();
    }),
    every(FORCE_HZ, () => status.sample()),
    every(STATUS_HZ, () => {
      if (!foxglove.hasStatusReaders) return;
      foxglove.sendStatus({ ...status.take(), state: shown.state, canStart: shown.canStart, canStop: shown.canStop,
        assets: shown.source?.assetsId ?? "", parameters: description.parameters ?? [] });
    })];
  shown.on("message", (message) => {
    if (ruleOf(message.topic).class === LATEST) newest.set(message.topic, message);
    else take(message);
    foxglove.forward(message);
  });
  shown.on("topics", (topics) => topics.filter(findRule).forEach((name) => foxglove.announce(name, ruleOf(name).type)));
  shown.on("begin", (node) => status.attach(node));
  shown.on("assets", () => foxglove.forgetPage());
  shown.on("frame", (bytes) => foxglove.sendPage("/page/frame", bytes));
  shown.on("sheets", (bytes) => foxglove.sendPage("/page/sheets", bytes));
  shown.on("picture", (why) => status.addEvent("scene_stream", "ended", why));
  shown.on("end", (why) => {
    status.addEvent("web_bridge", "session", why);
    status.attach(null);
  });
  await shown.begin();
  const view = wanted.view ? `&view=${encodeURIComponent(wanted.view)}` : "";
  console.log(JSON.stringify({ page: `http://${wanted.host}:${page.port}/#key=${key}${view}`,
    websocket: `ws://${wanted.host}:${page.port}/?key=${key}` }));

  const stop = async () => {
    timers.forEach(clearInterval);
    foxglove.close();
    page.close();
    await shown.close();
    process.exit(0);
  };
  process.once("SIGINT", stop).once("SIGTERM", stop);
}

main().catch((error) => {
  console.error(`web_bridge: ${error.message}`);
  process.exit(1);
});
