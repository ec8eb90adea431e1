// Serves the page: three files, the scene once, and changes as server-sent events.

import { readFileSync } from "node:fs";
import http from "node:http";
import { toScreen } from "./scene.mjs";

const STATUS_HZ = 20;
const FILES = { "/": ["index.html", "text/html"], "/status.js": ["status.js", "text/javascript"],
  "/view.js": ["view.js", "text/javascript"] };

// The scene with its linear colours converted to sRGB.
function sceneForPage(description) {
  return JSON.stringify({ ...description,
    objects: description.objects.map((object) =>
      ({ ...object, base_color: object.base_color && toScreen(object.base_color) })),
    meshes: description.meshes.map((parts) =>
      parts.map((part) => ({ ...part, base_color: toScreen(part.base_color) }))) });
}

export class PageServer {
  #http; #streams = new Set(); #timer;

  constructor({ status, scene, host, port }) {
    const sceneText = scene ? sceneForPage(scene.description) : "null";
    this.#http = http.createServer((request, response) => {
      const headers = { "Cache-Control": "no-store", "X-Content-Type-Options": "nosniff",
        "Content-Security-Policy": "default-src 'self'; style-src 'self' 'unsafe-inline'" };
      if (request.method !== "GET") {
        response.writeHead(405).end();
      } else if (FILES[request.url]) {
        const [file, type] = FILES[request.url];
        response.writeHead(200, { ...headers, "Content-Type": `${type}; charset=utf-8` });
        response.end(readFileSync(new URL(`page/${file}`, import.meta.url)));
      } else if (request.url === "/scene.json") {
        response.writeHead(200, { ...headers, "Content-Type": "application/json" }).end(sceneText);
      } else if (request.url === "/status") {
        response.writeHead(200, { ...headers, "Content-Type": "text/event-stream" });
        this.#streams.add(response);
        response.on("close", () => this.#streams.delete(response));
      } else {
        response.writeHead(404).end();
      }
    }).listen(port, host);
    this.#timer = setInterval(() => {
      if (this.#streams.size === 0) return;
      const shown = status.snapshot();
      shown.sheets = shown.sheets.map((sheet) => ({ ...sheet, base_color: toScreen(sheet.base_color),
        positions: sheet.positions.map((value) => Number(value.toFixed(4))) }));
      const text = `data: ${JSON.stringify(shown)}\n\n`;
      for (const stream of this.#streams) if (stream.writableLength < 1 << 20) stream.write(text);
    }, 1000 / STATUS_HZ);
  }

  listening() { return new Promise((resolve, reject) => this.#http.once("listening", resolve).once("error", reject)); }
  get port() { return this.#http.address().port; }

  close() {
    clearInterval(this.#timer);
    for (const stream of this.#streams) stream.end();
    this.#http.close();
  }
}
