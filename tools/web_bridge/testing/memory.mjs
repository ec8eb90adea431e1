// How much memory processes hold by themselves: anonymous and shared pages that are resident, not files.

import { readFileSync } from "node:fs";

export function heldMB(pid) {
  const status = readFileSync(`/proc/${pid}/status`, "utf8");
  const kB = (name) => Number(new RegExp(`^${name}:\\s+(\\d+)`, "m").exec(status)?.[1] ?? 0);
  return (kB("RssAnon") + kB("RssShmem")) / 1024;
}

export const childrenOf = (pid) => readFileSync(`/proc/${pid}/task/${pid}/children`, "utf8").split(" ").filter(Boolean).map(Number);

// A Node.js that was started with COLLECT and is told to collect what nobody needs: each waits to do so until it has to.
export const COLLECT = ["--expose-gc", "--import", "data:text/javascript,process.on('SIGUSR2',()=>gc())"];
export const collect = (child) => child.kill("SIGUSR2");

// Of a browser, by what its processes are for: {browser, renderer, GPU, ...}.
export async function heldByBrowserMB(page) {
  const { processInfo } = await page.sendToBrowser("SystemInfo.getProcessInfo");
  const held = {};
  for (const { type, id } of processInfo) held[type] = (held[type] ?? 0) + heldMB(id);
  return held;
}
