// The bridge as the page sees it: what is loaded once, and foxglove.websocket.v1. Emits what arrives through `on`:
// frame, sheets, status (parsed), refused (the key is wrong), off, on (the connection).

import { fromBinary } from "@bufbuild/protobuf/from-binary.js";
import { createFileRegistry } from "@bufbuild/protobuf/registry.js";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt/google/protobuf/descriptor_pb.js";
import FoxgloveClient from "@foxglove/ws-protocol";

const CHANNELS = { "/page/frame": "frame", "/page/sheets": "sheets", "/page/status": "status" };
const AGAIN_MS = 1000;

export class Link {
  #client = null; #topics = new Map(); #registry = null; #services = new Map(); #calls = new Map(); #nextCall = 1;
  #known; #served; #wait;

  constructor(key, on) {
    this.key = key;
    this.on = on;
    this.known = new Promise((resolve) => { this.#known = resolve; });  // the messages' types
    this.served = new Promise((resolve) => { this.#served = resolve; });  // the services' names
    this.#connect();
  }

  #connect() {
    const { protocol, host } = location;
    const client = new FoxgloveClient({ ws: new WebSocket(`${protocol === "https:" ? "wss" : "ws"}://${host}/`,
      [FoxgloveClient.SUPPORTED_SUBPROTOCOL, `oos.key.${this.key}`]) });
    this.#client = client;
    client.on("open", () => this.on.on?.());
    client.on("error", () => {});  // "close" follows
    client.on("close", () => {
      this.#topics.clear();
      this.#services.clear();
      for (const { reject } of this.#calls.values()) reject(new Error("the bridge has gone"));
      this.#calls.clear();
      this.on.off?.();
      clearTimeout(this.#wait);
      this.#wait = setTimeout(() => this.#connect(), AGAIN_MS);
    });
    client.on("advertise", (channels) => channels.forEach((channel) => this.#subscribe(channel)));
    client.on("message", ({ subscriptionId, data }) => {
      const [what, topic] = this.#topics.get(subscriptionId) ?? [];
      if (what === "status") this.on.status(JSON.parse(new TextDecoder().decode(data)));
      else if (what) this.on[what]({ topic, bytes: new Uint8Array(data.buffer, data.byteOffset, data.byteLength) });
    });
    client.on("advertiseServices", (services) => {
      services.forEach(({ id, name }) => this.#services.set(name, id));
      this.#served();
    });
    client.on("serviceCallResponse", ({ callId, data }) =>
      this.#answer(callId, (call) => call.resolve(JSON.parse(new TextDecoder().decode(data)))));
    client.on("serviceCallFailure", ({ callId, message }) =>
      this.#answer(callId, (call) => call.reject(new Error(message))));
    client.on("status", ({ message }) => this.on.said?.(message, true));
    client.on("parameterValues", ({ parameters }) => parameters.filter(({ name }) => !name.startsWith("scene."))
      .forEach(({ name, value }) => this.on.said?.(`${name} = ${value}`, false)));
  }

  #answer(callId, settle) {
    const call = this.#calls.get(callId);
    this.#calls.delete(callId);
    if (call) settle(call);
  }

  #subscribe({ id, topic, schema, schemaEncoding }) {
    const what = CHANNELS[topic];
    if (!what) return;
    if (schemaEncoding === "protobuf" && !this.#registry) {
      const bytes = Uint8Array.from(atob(schema), (c) => c.charCodeAt(0));
      this.#registry = createFileRegistry(fromBinary(FileDescriptorSetSchema, bytes));
      this.#known();
    }
    this.#topics.set(this.#client.subscribe(id), [what, topic]);
  }

  decode(type, bytes) { return fromBinary(this.#registry.getMessage(`oos.${type}`), bytes); }

  // Of what needs the key: "assets", "block/7". Null: there is none.
  async load(name) {
    const early = name === "assets" && window.early;
    window.early = name === "assets" ? null : window.early;
    const answer = await (early || fetch(`session/${name}`, { headers: { Authorization: `Bearer ${this.key}` } }));
    if (answer.status === 401) throw new Error("refused");
    return answer.status === 200 ? new Uint8Array(await answer.arrayBuffer()) : null;
  }

  call(service, request = {}) {
    return new Promise((resolve, reject) => {
      const serviceId = this.#services.get(service);
      if (serviceId === undefined) {
        reject(new Error(`the bridge does not offer ${service}`));
        return;
      }
      const callId = this.#nextCall++;
      this.#calls.set(callId, { resolve, reject });
      this.#client.sendServiceCallRequest({ serviceId, callId, encoding: "json",
        data: new DataView(new TextEncoder().encode(JSON.stringify(request)).buffer) });
    });
  }
  offers(service) { return this.#services.has(service); }

  setParameter(name, value) { this.#client.setParameters([{ name, value }], name); }
}
