// Shows a running session to Foxglove or Lichtblick (foxglove.websocket.v1) and to web browsers (a page of its own). It
// joins the bus as an observer and writes nothing. See README.md.

import { execFileSync } from "node:child_process";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { LATEST, Node, findRule, ruleOf, runningSession } from "../../clients/javascript/oos_bus.mjs";
import { SceneServer } from "./foxglove_server.mjs";
import { PageServer } from "./page_server.mjs";
import { Scene } from "./scene.mjs";
import { Status } from "./status.mjs";

const USAGE = `usage: node bridge.mjs SCENARIO [options]
  --registry ENDPOINT --session N   the session to show; default: the one running on this machine
  --keys DIR                        with --registry: the session's key directory; default: not encrypted
  --host ADDRESS                    address to serve on; default: 127.0.0.1 (this machine only)
  --websocket_port N                port for Foxglove; default: 8765
  --page_port N                     port of the page; default: 8080
  --oos FILE                        the program oos; default: build/release/bin/oos
  --topics PATTERNS                 topics to show, separated by commas; default: *
`;

const APPLY_HZ = 30;
const STRING = { type: "string" };
const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");

function readArguments() {
  const { values, positionals } = parseArgs({ allowPositionals: true, options: {
    registry: STRING, session: STRING, keys: STRING, oos: STRING, help: { type: "boolean" },
    host: { ...STRING, default: "127.0.0.1" }, websocket_port: { ...STRING, default: "8765" },
    page_port: { ...STRING, default: "8080" }, topics: { ...STRING, default: "*" } } });
  if (values.help || positionals.length !== 1) {
    console.error(USAGE);
    process.exit(values.help ? 0 : 2);
  }
  const session = values.registry
    ? { registry: values.registry, session: BigInt(values.session ?? 0), keys: values.keys ?? null } : runningSession();
  return { ...values, session, scenario: positionals[0], oos: values.oos ?? path.join(ROOT, "build/release/bin/oos") };
}

async function main() {
  const wanted = readArguments();
  const description = JSON.parse(execFileSync(wanted.oos, ["check", "--json", wanted.scenario],
    { encoding: "utf8", maxBuffer: 1 << 28 }));
  const scene = new Scene(description);
  const node = new Node({ name: `oos-web-${process.pid}`, ...wanted.session });
  for (const pattern of wanted.topics.split(",")) node.subscribe(pattern);
  const status = new Status(node, scene);
  const foxglove = new SceneServer({ name: `VR-OOS ${description.name}`, scene, host: wanted.host,
    port: Number(wanted.websocket_port) });
  const page = new PageServer({ status, scene, host: wanted.host, port: Number(wanted.page_port) });
  await Promise.all([foxglove.listening(), page.listening()]);

  foxglove.announce("event", "oos.Event");
  node.on("roster", () => {
    for (const { topics } of node.records()) {
      for (const { name } of topics.filter((one) => one.isWritten && findRule(one.name))) {
        foxglove.announce(name, ruleOf(name).type);
      }
    }
  });
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
  const applying = setInterval(() => {
    newest.forEach(take);
    newest.clear();
  }, 1000 / APPLY_HZ);
  node.on("message", (message) => {
    if (ruleOf(message.topic).class === LATEST) newest.set(message.topic, message);
    else take(message);
    foxglove.forward(message);
  });
  await node.start();
  console.log(JSON.stringify({ websocket: `ws://${wanted.host}:${foxglove.port}`,
    page: `http://${wanted.host}:${page.port}/` }));

  const stop = async () => {
    clearInterval(applying);
    foxglove.close();
    page.close();
    await node.close();
    process.exit(0);
  };
  process.once("SIGINT", stop).once("SIGTERM", stop);
}

main().catch((error) => {
  console.error(`web_bridge: ${error.message}`);
  process.exit(1);
});
