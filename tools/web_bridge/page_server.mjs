// Serves the page and what it loads once. The page itself has no word of the session and is for anybody; everything else
// needs the key.

import { createHash } from "node:crypto";
import { readFile, readFileSync } from "node:fs";
import http from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";

const HERE = path.dirname(fileURLToPath(import.meta.url));
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".css": "text/css" };
// Of npm's packages, what a browser loads.
const PACKAGES = ["three/build", "three/examples/jsm", "@bufbuild/protobuf/dist/esm", "@foxglove/ws-protocol/dist/esm", "eventemitter3"];

// The file of an address; none: there is none. "/npm/NAME/..." are packages; imports without an ending mean ".js".
function fileOf(url) {
  const name = decodeURIComponent(url.pathname);
  if (name === "/") return path.join(HERE, "page/index.html");
  const isPackage = name.startsWith("/npm/") && PACKAGES.some((one) => name.startsWith(`/npm/${one}/`));
  const base = path.join(HERE, isPackage ? "node_modules" : "page");
  const file = path.join(base, isPackage ? name.slice("/npm/".length) : name);
  if (!file.startsWith(base + path.sep)) return null;
  return TYPES[path.extname(file)] ? file : isPackage ? `${file}.js` : null;
}

// The page's import map is the only script that stands in it.
function policy() {
  const html = readFileSync(path.join(HERE, "page/index.html"), "utf8");
  const map = html.match(/<script type="importmap">([^]*?)<\/script>/)[1];
  const hash = createHash("sha256").update(map).digest("base64");
  return `default-src 'none'; script-src 'self' 'sha256-${hash}'; style-src 'self' 'unsafe-inline'; ` +
    "connect-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
}

export class PageServer {
  #files = new Map();
  #headers = { "Cache-Control": "no-cache", "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer",
    "Content-Security-Policy": policy() };

  // `secret`: by address, a function that returns {type, bytes, encoding} or null, of the rest of the address.
  constructor({ access, secret, host, port }) {
    this.access = access;
    this.secret = secret;
    this.http = http.createServer((request, response) => {
      try {
        this.#answer(request, response);
      } catch {  // an address that is none
        response.writeHead(400, this.#headers).end();
      }
    }).listen(port, host);
  }

  listening() { return new Promise((resolve, reject) => this.http.once("listening", resolve).once("error", reject)); }
  get port() { return this.http.address().port; }

  #answer(request, response) {
    const url = new URL(request.url, "http://bridge");
    const end = (status, text = "") => response.writeHead(status, this.#headers).end(text);
    if (request.method !== "GET") return end(405);
    const [, first, rest] = url.pathname.match(/^\/session\/([a-z]+)(?:\/(.*))?$/) ?? [];
    if (first) return this.#answerSecret(request, response, first, rest, end);
    const file = fileOf(url);
    if (!file) return end(404);
    const send = (bytes) => response.writeHead(200, { ...this.#headers,
      "Content-Type": `${TYPES[path.extname(file)]}; charset=utf-8` }).end(bytes);
    if (this.#files.has(file)) return send(this.#files.get(file));
    return readFile(file, (error, bytes) => {
      if (error) return end(404);
      this.#files.set(file, bytes);
      return send(bytes);
    });
  }

  #answerSecret(request, response, name, rest, end) {
    if (!this.access.isAllowed(request)) return end(401, "the session's key is missing or wrong");
    if (!Object.hasOwn(this.secret, name)) return end(404);
    const found = this.secret[name](rest);
    if (!found) return end(204);  // none yet: scene_stream has just begun
    response.writeHead(200, { ...this.#headers, "Cache-Control": "no-store", "Content-Type": found.type,
      ...(found.encoding && { "Content-Encoding": found.encoding }) });
    return response.end(found.bytes);
  }

  close() {
    this.http.closeAllConnections?.();
    this.http.close();
  }
}
