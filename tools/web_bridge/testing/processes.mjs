// Programs that a test starts and ends. Environment variable OOS: the program oos, beside the others.

import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { spawnBound } from "../../../clients/javascript/testing/spawn_bound.mjs";

// Twenty seconds less than ctest waits, to say what is late. A busy machine needs it, and the first run of a scene, which
// cooks its structures.
export const PATIENCE = { signal: AbortSignal.timeout((Number(process.env.PATIENCE_S ?? 300) - 20) * 1000) };
// A name, or a folder's absolute path, which stays.
export const scenarioFolder = (name) => path.resolve(fileURLToPath(new URL("../../../scenarios", import.meta.url)), name);

export class Processes {
  folder = mkdtempSync(path.join(tmpdir(), "web_bridge-"));
  said = [];
  #children = [];

  // With a runtime folder of its own it finds no session but its own, and what it leaves without being told where is
  // there, too.
  start(program, words) {
    const child = spawnBound(program, words, { cwd: this.folder, env: { ...process.env, XDG_RUNTIME_DIR: this.folder },
      stdio: ["ignore", "pipe", "pipe"] });
    for (const input of [child.stdout, child.stderr]) {
      createInterface({ input }).on("line", (line) => this.said.push(line));
    }
    this.#children.push(child);
    return child;
  }

  // The first line of a child's output that meets the condition.
  lineOf(child, condition) {
    return new Promise((resolve, reject) => {
      createInterface({ input: child.stdout }).on("line", (line) => condition(line) && resolve(line));
      child.once("exit", () => reject(new Error(this.said.join("\n"))));
      PATIENCE.signal.addEventListener("abort", () => reject(new Error(`too late\n${this.said.join("\n")}`)));
    });
  }

  // A session; from the return on a bridge finds it.
  async startSession(scenario, options = []) {
    const run = this.start(process.env.OOS, ["run", scenarioFolder(scenario), "--headless", "--without", "visual_node",
      "--rt", "off", "--out", path.join(this.folder, "out"), ...options]);
    await this.lineOf(run, (line) => line.startsWith("starting"));
    return run;
  }

  // {page, websocket, key, child}. `nodeOptions`: of Node.js, which runs the bridge.
  async startBridge(scenario, options = [], nodeOptions = []) {
    const child = this.start(process.execPath, [...nodeOptions, fileURLToPath(new URL("../bridge.mjs", import.meta.url)),
      scenarioFolder(scenario), "--programs", path.dirname(process.env.OOS), "--port", "0", ...options]);
    const where = JSON.parse(await this.lineOf(child, (line) => line.startsWith("{")));
    return { ...where, child, key: new URL(where.page).hash.slice("#key=".length), origin: new URL(where.page).origin };
  }

  async end(child, signal = "SIGTERM") {
    if (child.exitCode !== null || child.signalCode !== null) return;
    child.kill(signal);
    await once(child, "exit");
  }

  async endAll() {
    for (const child of this.#children.reverse()) await this.end(child);
    rmSync(this.folder, { recursive: true, force: true });
  }
}
