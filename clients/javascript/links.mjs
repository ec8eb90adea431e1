// A node's sockets, and sending and receiving envelopes through them, encrypted or not.

import dgram from "node:dgram";
import { randomBytes } from "node:crypto";
import { EventEmitter } from "node:events";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { Context, Dealer, Reply, Router } from "zeromq";
import { CONTROL, EVENT, LATEST, SERVICE, STATE, hash32, readEnvelope, writeEnvelope } from "./envelope.mjs";
import { loadKeys, z85 } from "./security.mjs";
import { typeOf } from "./topics.mjs";

export const PROTOCOL_VERSION = 1;
const Control = typeOf("oos.Control");

const classOf = (body) => body.startsWith("sub") || body.startsWith("state") ? STATE
  : body.startsWith("ev") ? EVENT : body.startsWith("parameter") ? SERVICE : CONTROL;

// A socket and the queue of its sends: ZeroMQ allows one at a time. A send that cannot proceed is dropped.
class Link {
  #busy = Promise.resolve();
  constructor(socket) { this.socket = socket; }
  send(frames) {
    const done = this.#busy.then(() => this.socket.send(frames)).then(() => true, () => false);
    this.#busy = done;
    return done;
  }
}

export class Links extends EventEmitter {
  refused = 0;
  _instance = randomBytes(8).readBigUInt64LE();
  _boot = BigInt(Date.now()) * 1_000_000n;
  _context = new Context();
  _sealer = null;  // of datagrams, from the registry's session key
  _allowList = null;
  _closing = null;  // close() has begun; resolves when it has ended
  _isClosed = false;

  constructor(options) {  // {name, registry, session, keys, bind, isObserver}
    super();
    if (options.keys === undefined) throw new Error("keys: give the run's key directory, or null if it has none");
    this._options = { bind: "127.0.0.1", isObserver: true, ...options };
    this._keys = options.keys && loadKeys(options.keys, options.name);
  }

  async _openLinks() {
    const { bind, registry } = this._options;
    this._data = await this._udp((bytes) => this._takeData(bytes));
    this._beats = await this._udp((bytes) => this._takeHeartbeat(bytes));
    this._router = new Link(new Router({ context: this._context, mandatory: true, handover: true, linger: 100,
      maxMessageSize: 16 << 20, sendTimeout: 0,
      ...(this._keys && { curveServer: true, curveSecretKey: this._keys.secretKey, zapDomain: "bus" }) }));
    if (this._keys) await this._answerAuthentication();
    await this._router.socket.bind(`tcp://${bind}:*`);
    this._registry = this._dealer(registry, this._keys?.registryKey);
    this._receive(this._router.socket, ([routing, ...rest]) => this._takeRouter(routing, rest.at(-1)));
    this._receive(this._registry.socket, (frames) => this._takeRegistry(frames.at(-1)));
  }

  _closeLinks() {
    this._router?.socket.close();
    this._registry?.socket.close();
    this._allowList?.close();
    this._data.close();
    this._beats?.close();
  }

  _udp(take) {
    return new Promise((resolve, reject) => {
      const udp = dgram.createSocket({ type: "udp4", recvBufferSize: 1 << 20 });
      // Errors after the binding are ignored: a datagram that cannot be sent (a pulled cable) is lost, as any may be.
      udp.on("message", take).on("error", reject);
      udp.bind(0, this._options.bind, () => resolve(udp));
    });
  }

  // libzmq's authentication requests: whether the owner of a key, who has proven to own it, may connect [ZeroMQ RFC 27].
  async _answerAuthentication() {
    this._allowList = new Reply({ context: this._context, linger: 0 });
    await this._allowList.bind("inproc://zeromq.zap.01");
    this._receive(this._allowList, ([version, request, , , , mechanism, key]) => {
      const owner = mechanism.toString() === "CURVE" && this._keys.allowed.get(z85(key));
      return this._allowList.send([version, request, owner ? "200" : "400", "", owner || "", ""]);
    });
  }

  _dealer(endpoint, serverKey) {
    const dealer = new Dealer({ context: this._context, routingId: `${this._options.name}#${this._instance}`,
      immediate: true, linger: 100, reconnectInterval: 20, reconnectMaxInterval: 200, maxMessageSize: 16 << 20,
      sendTimeout: 0, ...(this._keys && { curveServerKey: serverKey, curvePublicKey: this._keys.publicKey,
        curveSecretKey: this._keys.secretKey }) });
    dealer.connect(endpoint);
    return new Link(dealer);
  }

  async _receive(socket, take) {
    try {
      for await (const frames of socket) if (!this._isClosed) await take(frames);
    } catch (error) {
      if (!this._isClosed && !socket.closed) throw error;
    }
  }

  _stamp() {
    return { topic: 0, digest: PROTOCOL_VERSION, session: this._options.session, node: hash32(this._options.name),
      boot: this._boot, sequence: 0n, publishNs: process.hrtime.bigint() };
  }

  _wrap(kind, value, sealer) {
    return writeEnvelope({ ...this._stamp(), topicClass: classOf(kind) },
      toBinary(Control, create(Control, { body: { case: kind, value } })), sealer);
  }

  // The body of the Control in a sound envelope of this session; otherwise an empty one, and `refused` counts it.
  _open(bytes, unsealer) {
    const found = readEnvelope(bytes, unsealer);
    if (found && found.envelope.session === this._options.session && found.envelope.topicClass !== LATEST) {
      try {
        return fromBinary(Control, found.payload).body;
      } catch { /* counted below */ }
    }
    ++this.refused;
    return { case: undefined };
  }

  _send(link, kind, value) { return link.send(this._wrap(kind, value)); }

  _reply(routing, kind, value) { return this._router.send([Buffer.from(routing, "latin1"), this._wrap(kind, value)]); }
}
