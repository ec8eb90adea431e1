// The program scene_stream, which turns a session, a recording, or a scenario as it begins into what the page draws. It keeps the newest of what the
// program said, for viewers that come later. Emits "frame", "sheets" (bytes), "end" (what it said last).

import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { EventEmitter } from "node:events";
import { gzipSync } from "node:zlib";

const MAX_BLOCKS = 64;  // of points; the oldest are forgotten

export class SceneSource extends EventEmitter {
  assets = null;  // gzip of a SceneAssets
  frame = null;   // SceneFrame
  sheets = null;  // SceneSheets
  blocks = new Map();
  assetsId = "";  // of their content; empty: none yet
  #child; #rest = []; #length = 0; #said = "";

  constructor({ program, scenario, recording, session, name }) {
    super();
    const from = recording ? ["--recording", recording] : !session ? []
      : ["--registry", session.registry, "--session", String(session.session), "--name", name,
        ...(session.bind ? ["--bind", session.bind] : []), ...(session.keys ? ["--keys", session.keys] : ["--no_encryption"])];
    this.#child = spawn(program, ["--scenario", scenario, ...from], { stdio: ["pipe", "pipe", "pipe"] });
    this.#child.stdout.on("data", (bytes) => this.#take(bytes));
    this.#child.stdin.on("error", () => {});  // its end is reported below
    this.#child.stderr.on("data", (bytes) => { this.#said = String(bytes).trim(); });
    this.#child.on("error", (error) => this.emit("end", error.message));
    this.#child.on("exit", () => this.emit("end", this.#said));
  }

  #take(bytes) {
    this.#rest.push(bytes);
    this.#length += bytes.length;
    while (this.#length >= 5) {
      if (this.#rest[0].length < 4) this.#rest = [Buffer.concat(this.#rest)];
      const needed = 4 + this.#rest[0].readUInt32LE(0);
      if (this.#length < needed) return;
      const all = this.#rest.length === 1 ? this.#rest[0] : Buffer.concat(this.#rest);
      this.#keep(String.fromCharCode(all[4]), all.subarray(5, needed));
      this.#length -= needed;
      this.#rest = this.#length > 0 ? [all.subarray(needed)] : [];
    }
  }

  #keep(kind, bytes) {
    if (kind === "A") {
      this.assets = gzipSync(bytes, { level: 1 });
      this.assetsId = createHash("sha256").update(bytes).digest("hex");
      this.emit("assets");
    } else if (kind === "F") {
      this.emit("frame", this.frame = bytes);
    } else if (kind === "S") {
      this.emit("sheets", this.sheets = bytes);
    } else if (kind === "B") {
      this.blocks.set(bytes.readUInt32LE(0), Buffer.from(bytes.subarray(4)));
      if (this.blocks.size > MAX_BLOCKS) this.blocks.delete(this.blocks.keys().next().value);
    }
  }

  // A line of scene_stream/commands.hpp.
  say(line) { if (!line.includes("\n")) this.#child.stdin.write(`${line}\n`); }

  close() { this.#child.kill("SIGTERM"); }
}
