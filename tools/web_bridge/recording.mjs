// A recording that is shown, in place of a session. Emits "frame", "sheets", "assets", "picture" (why there is none).

import { EventEmitter } from "node:events";
import { SceneSource } from "./scene_source.mjs";

const COMMANDS = ["play", "pause"], NUMBERS = ["seek", "speed"];

export class Recording extends EventEmitter {
  state = "recording";
  node = null;
  canStart = false;
  canStop = false;

  constructor({ scenario, programs, file }) {
    super();
    Object.assign(this, { scenario, programs, file });
  }

  async begin() {
    this.source = new SceneSource({ program: this.programs.sceneStream, scenario: this.scenario, recording: this.file });
    for (const what of ["assets", "frame", "sheets"]) this.source.on(what, (bytes) => this.emit(what, bytes));
    this.source.on("end", (why) => this.emit("picture", why));
  }

  // "play", "pause", "seek" (to seconds), "speed" (recorded seconds per second).
  control(command, value) {
    if (COMMANDS.includes(command)) this.source.say(command);
    else if (NUMBERS.includes(command) && Number.isFinite(value)) this.source.say(`${command} ${value}`);
    else throw new Error(`a recording knows ${[...COMMANDS, ...NUMBERS].join(", ")}, not '${command}'`);
  }

  async close() { this.source.close(); }
}
