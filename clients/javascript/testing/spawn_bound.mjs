import { spawn } from "node:child_process";

// As spawn, but the kernel ends the child when this process ends, however that is (PR_SET_PDEATHSIG): a test that is
// killed leaves nothing behind.
export const spawnBound = (program, words, options) => spawn("setpriv", ["--pdeathsig", "TERM", "--", program, ...words], options);
