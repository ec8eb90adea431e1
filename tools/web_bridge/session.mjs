// The session that is shown: joins it, follows its end, starts and stops it. Emits "message" (of the bus), "begin" (its
// node), "topics" (names), "frame", "sheets", "assets" (of scene_stream), "end" (why).

import { spawn } from "node:child_process";
import { EventEmitter } from "node:events";
import { readFileSync } from "node:fs";
import { Node, runningSession } from "../../clients/javascript/oos_bus.mjs";
import { SceneSource } from "./scene_source.mjs";

const LOOK_MS = 500;
const SILENCE_MS = 3000;  // without any live node but observers, a session is over

export class Session extends EventEmitter {
  state = "none";  // "running", "starting", "stopping"
  source = null;
  node = null;
  #timer; #run = null; #quietSinceMs = null; #joined = null; #isClosed = false;

  // `fixed`: the session of --registry, or null: the one that runs on this machine.
  // `name`: of the viewer that the page is on the bus.
  constructor({ scenario, programs, topics, fixed, name }) {
    super();
    Object.assign(this, { scenario, programs, topics, fixed, name });
  }

  // The session that could be joined now, or null.
  find() {
    if (this.fixed) return this.fixed;
    try {
      const session = runningSession();
      return this.#isAlive() ? session : null;
    } catch {
      return null;
    }
  }

  // `oos run` notes down its process.
  #note() {
    const runtime = process.env.XDG_RUNTIME_DIR;
    const folder = runtime ? `${runtime}/vr_oos` : `/tmp/vr_oos-${process.geteuid()}`;
    return JSON.parse(readFileSync(`${folder}/session.json`, "utf8"));
  }
  #isAlive() {
    try {
      return process.kill(this.#note().pid, 0);
    } catch {
      return false;
    }
  }

  async begin() {
    const found = this.find();
    if (found) await this.#join(found);
    else this.#showBegin();
    this.#timer = setInterval(() => this.#look(), LOOK_MS);
  }

  // Before a session, the scenario as it begins.
  #showBegin() {
    this.source = this.#follow(new SceneSource({ program: this.programs.sceneStream, scenario: this.scenario }));
  }

  async #join(session) {
    this.#joined = session;
    const node = new Node({ name: `oos-web-${process.pid}`, ...session });
    node.on("message", (message) => this.emit("message", message));
    node.on("roster", () => this.emit("topics", node.records().flatMap(({ topics }) =>
      topics.filter((one) => one.isWritten).map(({ name }) => name))));
    for (const pattern of this.topics) node.subscribe(pattern);
    await node.start();
    this.node = node;
    this.#quietSinceMs = null;
    this.source?.close();
    this.#show();
    this.state = "running";
    this.emit("begin", node);
  }

  // The pictures of the session that was joined.
  #show() {
    this.source = this.#follow(new SceneSource({ program: this.programs.sceneStream, scenario: this.scenario,
      session: this.#joined, name: this.name }));
  }

  #follow(source) {
    for (const what of ["assets", "frame", "sheets"]) source.on(what, (bytes) => this.emit(what, bytes));
    source.on("end", (why) => {
      if (this.source !== source || this.#isClosed) return;
      this.source = null;
      this.emit("picture", why);
    });
    return source;
  }

  #isBusy = false;
  async #look() {
    if (this.#isBusy || this.#isClosed) return;
    this.#isBusy = true;
    try {
      if (this.node && this.#isOver()) await this.#leave("the session is over");
      // As its host's supervisor does with any other node of a lab.
      if (this.fixed && this.node && !this.source) this.#show();
      const found = !this.node && this.find();
      if (found && !this.#isSame(found)) await this.#join(found);
    } catch (error) {
      this.node = null;  // it has not begun yet; the next look tries again
    } finally {
      this.#isBusy = false;
    }
  }

  // A session that ended is not joined again.
  #isSame(found) {
    return !this.fixed && this.#joined?.session === found.session && this.#joined?.registry === found.registry;
  }

  // A --registry is followed for ever, as its nodes may come back.
  #isOver() {
    if (this.fixed) return false;
    const isQuiet = !this.node.records().some((one) => one.isAlive && !one.isObserver && !one.name.startsWith("visual_node"));
    if (!isQuiet) this.#quietSinceMs = null;
    else this.#quietSinceMs ??= performance.now();
    return !this.#isAlive() || (isQuiet && performance.now() - this.#quietSinceMs > SILENCE_MS);
  }

  async #leave(why) {
    const { node } = this;
    this.node = null;  // its last picture stays until another session begins
    this.state = "none";
    await node?.close();
    this.emit("end", why);
  }

  get canStart() { return !this.fixed && !this.node && !this.#run; }
  get canStop() { return !this.fixed && this.node !== null && this.#isAlive(); }

  // Runs the scenario on this machine, without a window of its own.
  start() {
    if (!this.canStart) throw new Error("a session runs already");
    this.state = "starting";
    // The kernel ends it as stop() does when this process is killed.
    this.#run = spawn("setpriv", ["--pdeathsig", "INT", "--",
      this.programs.oos, "run", this.scenario, "--headless", "--without", "visual_node"],
      { stdio: ["ignore", "ignore", "pipe"] });
    let said = "";
    this.#run.stderr.on("data", (bytes) => { said = String(bytes).trim().split("\n").at(-1) || said; });
    this.#run.on("error", (error) => { said = error.message; });
    this.#run.on("close", (status) => {
      this.#run = null;
      if (this.state === "starting") this.state = "none";
      if (status !== 0) this.emit("picture", `oos run ended with ${status}: ${said}`);
    });
  }

  // As Ctrl-C at `oos run` does.
  stop() {
    if (this.#run) this.#run.kill("SIGINT");
    else if (this.canStop) process.kill(this.#note().pid, "SIGINT");
    else throw new Error("no session of this machine runs");
    this.state = "stopping";
  }

  async close() {
    this.#isClosed = true;
    clearInterval(this.#timer);
    this.#run?.kill("SIGINT");
    this.source?.close();
    await this.node?.close();
  }
}
