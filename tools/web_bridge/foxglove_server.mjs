// A server of foxglove.websocket.v1: a channel with the unchanged messages of every topic, the scene for the 3D panel, and
// for the page of this bridge the scene as it draws it, parameters, and services.

import protocol from "@foxglove/ws-protocol";
import { WebSocketServer } from "ws";
import { create, descriptors, toBinary, typeOf, wkt } from "../../clients/javascript/oos_bus.mjs";

const { FoxgloveServer } = protocol;
const MAX_WAITING_BYTES = 16 << 20;  // for one client; messages beyond it are dropped
const MAX_WAITING_FRAME_BYTES = 256 << 10;  // of what is out of date soon
const VIEWS = { "/viz/scene": "foxglove.SceneUpdate", "/viz/transforms": "foxglove.FrameTransforms" };
const PAGE = { "/page/frame": "oos.SceneFrame", "/page/sheets": "oos.SceneSheets" };
const STATUS = "/page/status";
const SCENE_HZ = 30, SHEET_HZ = 10;
const TEXT = { encoding: "json", schemaName: "oos.Json", schemaEncoding: "jsonschema", schema: '{"type":"object"}' };

const base64 = (bytes) => Buffer.from(bytes).toString("base64");
const wallClockNs = () => BigInt(Date.now()) * 1_000_000n;
const timestampOf = (ns) => ({ seconds: ns / 1_000_000_000n, nanos: Number(ns % 1_000_000_000n) });

// Descriptors of a message type's file, after those of the files that it imports.
function descriptorsOf(type) {
  const files = new Map(descriptors.file.map((file) => [file.name, file]));
  const wanted = new Map();
  const add = (name) => {
    files.get(name).dependency.forEach(add);
    wanted.set(name, files.get(name));
  };
  add(type.file.proto.name);
  return toBinary(wkt.FileDescriptorSetSchema,
    create(wkt.FileDescriptorSetSchema, { file: [...wanted.values()] }));
}

export class SceneServer {
  #server; #sockets; #channels = new Map(); #watched = new Set(); #timers = []; #newest = new Map();
  #services = new Map(); #isFrame = false;
  dropped = 0;

  // `services`: by name, async functions of an object that return an object. `setParameter`: async (name, value).
  constructor({ name, scene, http, access, services, setParameter }) {
    this.scene = scene;
    this.#server = new FoxgloveServer({ name, capabilities: ["parameters", "services"], supportedEncodings: ["json"] });
    this.#server.on("subscribe", (id) => this.#watched.add(id));
    this.#server.on("unsubscribe", (id) => this.#watched.delete(id));
    this.#server.on("error", (error) => console.error(`web_bridge: a Foxglove client: ${error.message}`));
    this.#server.on("serviceCallRequest", (request, socket) => this.#serve(request, socket));
    this.#server.on("getParameters", ({ id }, socket) => this.#server.publishParameterValues([], id, socket));
    this.#server.on("setParameters", ({ parameters, id }, socket) => this.#set(setParameter, parameters, id, socket));
    this.#sockets = new WebSocketServer({ noServer: true, maxPayload: 1 << 20,
      handleProtocols: (protocols) => this.#server.handleProtocols(protocols) });
    http.on("upgrade", (request, socket, head) => {
      socket.on("error", () => socket.destroy());
      if (!access.isAllowed(request)) {
        socket.end("HTTP/1.1 401 Unauthorized\r\nConnection: close\r\nContent-Length: 0\r\n\r\n");
        return;
      }
      this.#sockets.handleUpgrade(request, socket, head, (client) => this.#admit(client, request));
    });
    for (const [topic, typeName] of Object.entries({ ...VIEWS, ...PAGE })) this.announce(topic, typeName);
    this.#channels.set(STATUS, this.#server.addChannel({ topic: STATUS, ...TEXT }));
    for (const [service, call] of Object.entries(services)) {
      this.#services.set(this.#server.addService({ name: service, type: "oos.Json", request: TEXT, response: TEXT }), call);
    }
    this.#timers.push(setInterval(() => this.#view("/viz/transforms", (t) => scene.transforms(t)), 1000 / SCENE_HZ));
    this.#timers.push(setInterval(() => {
      if (scene.sheets.size > 0) this.#view("/viz/scene", (t) => scene.sheetUpdate(t));
    }, 1000 / SHEET_HZ));
  }

  #admit(socket, request) {
    const send = socket.send.bind(socket);
    socket.send = (data) => {
      const most = this.#isFrame ? MAX_WAITING_FRAME_BYTES : MAX_WAITING_BYTES;
      if (socket.bufferedAmount > most && typeof data !== "string") ++this.dropped;
      else send(data);
    };
    socket.on("error", () => {});  // "close" follows
    this.#server.handleConnection(socket, request.socket.remoteAddress ?? "?");
    // Meshes and sheets are sent once, so they are sent again for a client that subscribes later.
    socket.on("message", (data, isBinary) => {
      if (isBinary || !data.includes('"subscribe"')) return;
      setImmediate(() => {
        this.sendMeshes();
        for (const [topic, bytes] of this.#newest) this.#send(topic, bytes);
      });
    });
  }

  async #serve({ serviceId, callId, data }, socket) {
    try {
      const said = JSON.parse(new TextDecoder().decode(data) || "{}");
      const answer = await this.#services.get(serviceId)(said);
      const text = new TextEncoder().encode(JSON.stringify(answer ?? {}));
      this.#server.sendServiceCallResponse({ serviceId, callId, encoding: "json", data: new DataView(text.buffer) }, socket);
    } catch (error) {
      this.#server.sendServiceCallFailure({ op: "serviceCallFailure", serviceId, callId, message: error.message }, socket);
    }
  }

  // Tells of each what became of it; one that was refused is told by a status.
  async #set(setParameter, parameters, id, socket) {
    const taken = [];
    for (const { name, value } of parameters) {
      try {
        await setParameter(name, Number(value));
        taken.push({ name, value });
      } catch (error) {
        this.#server.sendStatus({ level: 2, message: `${name}: ${error.message}` }, socket);
      }
    }
    this.#server.publishParameterValues(taken, id, socket);
  }

  #view(topic, fill) {
    if (!this.#watched.has(this.#channels.get(topic))) return;
    const now = wallClockNs();
    const type = typeOf(VIEWS[topic]);
    this.#server.sendMessage(this.#channels.get(topic), now,
      toBinary(type, create(type, fill(timestampOf(now)))));
  }

  #send(topic, bytes) {
    const id = this.#channels.get(topic);
    if (this.#watched.has(id)) this.#server.sendMessage(id, wallClockNs(), bytes);
  }

  sendMeshes() { this.#view("/viz/scene", (t) => this.scene.meshes(t)); }

  // What the page draws. The newest is kept for clients that come later.
  sendPage(topic, bytes) {
    this.#newest.set(topic, bytes);
    this.#isFrame = topic !== "/page/sheets";
    this.#send(topic, bytes);
    this.#isFrame = false;
  }
  sendStatus(status) { this.sendPage(STATUS, new TextEncoder().encode(JSON.stringify(status))); }
  get hasStatusReaders() { return this.#watched.has(this.#channels.get(STATUS)); }
  forgetPage() { this.#newest.clear(); }

  // Adds a channel for a topic that a node of the bus writes.
  announce(topic, typeName) {
    if (this.#channels.has(topic)) return;
    this.#channels.set(topic, this.#server.addChannel({ topic, encoding: "protobuf", schemaName: typeName,
      schema: base64(descriptorsOf(typeOf(typeName))), schemaEncoding: "protobuf" }));
  }

  forward(message) {
    const id = this.#channels.get(message.topic);
    if (!this.#watched.has(id)) return;
    const { body } = message;
    this.#server.sendMessage(id, wallClockNs(), toBinary(typeOf(body.$typeName), body));
  }

  close() {
    this.#timers.forEach(clearInterval);
    for (const socket of this.#sockets.clients) socket.terminate();
    this.#sockets.close();
  }
}
