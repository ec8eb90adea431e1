// A session of scenarios/touch that lasts as long as a test, however slow the machine is.

import assert from "node:assert/strict";
import { appendFileSync, cpSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { scenarioFolder } from "./processes.mjs";

// A copy of the scenario in `folder`, whose procedure does not complete within an hour, and whose ball moves up and down
// at the end. Returns its folder.
export function lastingTouch(folder) {
  const copy = path.join(folder, "lasting");
  cpSync(scenarioFolder("touch"), copy, { recursive: true });
  const edit = (file, old, changed) => {
    const text = readFileSync(path.join(copy, file), "utf8");
    assert.ok(text.includes(old), `${file}: ${old}`);
    writeFileSync(path.join(copy, file), text.replace(old, changed));
  };
  edit("procedure.scxml", `delay="2.5s"`, `delay="3600s"`);
  edit("scenario.xml", `duration_limit_s="60" stall_limit_s="15"`, `duration_limit_s="3600" stall_limit_s="3600"`);
  const upAndDown = "  reach plate.block_path offset 0 0 0.06\n  reach plate.block_path\n";
  appendFileSync(path.join(copy, "operator.txt"), upAndDown.repeat(1000));
  return copy;
}
