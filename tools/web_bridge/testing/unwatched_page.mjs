// A page in a Chromium of its own that keeps nothing for a tool. Playwright has the browser keep the bodies of answers, up
// to a hundred megabytes in the page's process, as if the page held them.

import { once } from "node:events";
import path from "node:path";
import { createInterface } from "node:readline";
import WebSocket from "ws";
import { spawnBound } from "../../../clients/javascript/testing/spawn_bound.mjs";
import { CHROMIUM, FLAGS } from "./browser.mjs";

// By the DevTools protocol, no domain of which is on unless a test sends its `enable`.
export class UnwatchedPage {
  #child; #socket; #session; #next = 1; #asked = new Map();

  // `folder`: for the browser's profile.
  static async open(address, { width, height, folder }) {
    const page = new UnwatchedPage();
    page.#child = spawnBound(CHROMIUM, ["--headless", ...FLAGS, "--remote-debugging-port=0",
      `--user-data-dir=${path.join(folder, "unwatched")}`, `--window-size=${width},${height}`, "about:blank"],
    { stdio: ["ignore", "ignore", "pipe"] });
    const where = await new Promise((resolve, reject) => {
      createInterface({ input: page.#child.stderr }).on("line", (line) => {
        const found = /^DevTools listening on (ws:.*)$/.exec(line);
        if (found) resolve(found[1]);
      });
      page.#child.once("exit", () => reject(new Error(`${CHROMIUM} ended`)));
    });
    page.#socket = new WebSocket(where);
    await once(page.#socket, "open");
    page.#socket.on("message", (text) => page.#take(JSON.parse(text)));
    const { targetId } = await page.sendToBrowser("Target.createTarget", { url: "about:blank" });
    page.#session = (await page.sendToBrowser("Target.attachToTarget", { targetId, flatten: true })).sessionId;
    await page.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: false });
    await page.send("Page.navigate", { url: address });
    return page;
  }

  #take({ id, result, error }) {
    const { resolve, reject } = this.#asked.get(id) ?? {};
    this.#asked.delete(id);
    if (error) reject?.(new Error(error.message));
    else resolve?.(result);
  }

  #ask(message) {
    const id = this.#next++;
    this.#socket.send(JSON.stringify({ id, ...message }));
    return new Promise((resolve, reject) => this.#asked.set(id, { resolve, reject }));
  }

  sendToBrowser(method, params = {}) { return this.#ask({ method, params }); }
  send(method, params = {}) { return this.#ask({ method, params, sessionId: this.#session }); }

  // The result of a function of one argument, run in the page.
  async evaluate(what, argument = null) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate", { awaitPromise: true, returnByValue: true,
      expression: `(${what})(${JSON.stringify(argument)})` });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  async waitFor(condition) {
    while (!await this.evaluate(condition)) await new Promise((resolve) => setTimeout(resolve, 100));
  }

  async close() {
    this.#socket.close();
    this.#child.kill();
    await once(this.#child, "exit");
  }
}
