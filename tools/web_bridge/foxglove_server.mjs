// A server of foxglove.websocket.v1: a channel with the unchanged messages of every topic, and the scene for the 3D panel.

import protocol from "@foxglove/ws-protocol";
import { WebSocketServer } from "ws";
import { create, descriptors, toBinary, typeOf, wkt } from "../../clients/javascript/oos_bus.mjs";

const { FoxgloveServer } = protocol;
const MAX_WAITING_BYTES = 16 << 20;  // for one client; messages beyond it are dropped
const VIEWS = { "/viz/scene": "foxglove.SceneUpdate", "/viz/transforms": "foxglove.FrameTransforms" };
const SCENE_HZ = 30, SHEET_HZ = 10;

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
  #server; #sockets; #channels = new Map(); #watched = new Set(); #timers = [];
  dropped = 0;

  constructor({ name, scene, host, port }) {
    this.scene = scene;
    this.#server = new FoxgloveServer({ name, supportedEncodings: [] });
    this.#server.on("subscribe", (id) => this.#watched.add(id));
    this.#server.on("unsubscribe", (id) => this.#watched.delete(id));
    this.#server.on("error", (error) => console.error(`web_bridge: a Foxglove client: ${error.message}`));
    this.#sockets = new WebSocketServer({ host, port, maxPayload: 1 << 20,
      handleProtocols: (protocols) => this.#server.handleProtocols(protocols) });
    this.#sockets.on("connection", (socket, request) => this.#admit(socket, request));
    for (const [topic, typeName] of Object.entries(VIEWS)) this.announce(topic, typeName);
    this.#timers.push(setInterval(() => this.#view("/viz/transforms", (t) => scene.transforms(t)), 1000 / SCENE_HZ));
    this.#timers.push(setInterval(() => {
      if (scene.sheets.size > 0) this.#view("/viz/scene", (t) => scene.sheetUpdate(t));
    }, 1000 / SHEET_HZ));
  }

  listening() { return new Promise((resolve, reject) => this.#sockets.once("listening", resolve).once("error", reject)); }
  get port() { return this.#sockets.address().port; }

  #admit(socket, request) {
    const send = socket.send.bind(socket);
    socket.send = (data) => {
      if (socket.bufferedAmount > MAX_WAITING_BYTES && typeof data !== "string") ++this.dropped;
      else send(data);
    };
    this.#server.handleConnection(socket, request.socket.remoteAddress ?? "?");
    // The meshes are sent once, so they are sent again for a client that subscribes later.
    socket.on("message", (data, isBinary) => {
      if (!isBinary && data.includes('"subscribe"')) setImmediate(() => this.sendMeshes());
    });
  }

  #view(topic, fill) {
    if (!this.#watched.has(this.#channels.get(topic))) return;
    const now = wallClockNs();
    const type = typeOf(VIEWS[topic]);
    this.#server.sendMessage(this.#channels.get(topic), now,
      toBinary(type, create(type, fill(timestampOf(now)))));
  }

  sendMeshes() { this.#view("/viz/scene", (t) => this.scene.meshes(t)); }

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
