// Who may see the session: whoever knows its key for viewers.

import { createHmac, randomBytes, timingSafeEqual } from "node:crypto";
import { readFileSync, statSync } from "node:fs";
import path from "node:path";

const KEY_BYTES = 32;

// The session's key for viewers: whoever may read its key directory can compute it, nobody else. A session without
// encryption has none, so the bridge makes one for as long as it runs.
export function viewerKey(session) {
  if (!session?.keys) return randomBytes(KEY_BYTES).toString("base64url");
  const file = path.join(session.keys, "oos.key");
  const info = statSync(file);
  if (info.uid !== process.geteuid() || info.mode & 0o077) {
    throw new Error(`${file}: it must belong to this user, and no other may read it (mode 0600)`);
  }
  const secret = readFileSync(file, "utf8").split("\n")[1];
  const number = Buffer.alloc(8);
  number.writeBigUInt64LE(session.session);
  return createHmac("sha256", secret).update("VR-OOS viewer").update(number).digest("base64url");
}

// A viewer says the key as `Authorization: Bearer KEY`, as WebSocket protocol `oos.key.KEY`, or, as Foxglove can only be
// given an address, in it: ?key=KEY.
export class Access {
  refused = 0;
  #digest;

  constructor(key) { this.#digest = this.#digestOf(key); }

  // Of the same length whatever was said, so that comparing takes the same time.
  #digestOf(text) { return createHmac("sha256", "VR-OOS access").update(text).digest(); }

  #isKey(text) { return timingSafeEqual(this.#digestOf(text), this.#digest); }

  isAllowed(request) {
    const said = [request.headers.authorization?.match(/^Bearer (.+)$/)?.[1],
      new URL(request.url, "http://bridge").searchParams.get("key"),
      ...(request.headers["sec-websocket-protocol"] ?? "").split(",").map((one) => one.trim())
        .filter((one) => one.startsWith("oos.key.")).map((one) => one.slice("oos.key.".length))];
    const isAllowed = said.filter((one) => one).some((one) => this.#isKey(one));
    if (!isAllowed) ++this.refused;
    return isAllowed;
  }
}
