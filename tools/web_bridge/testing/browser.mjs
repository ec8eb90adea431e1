// Chromium without a window and without a GPU, for tests of the page.

import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

export const CHROMIUM = process.env.CHROMIUM || "/usr/bin/chromium";
export const hasChromium = existsSync(CHROMIUM);

export const FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage",
  "--disable-gpu-compositing", ...(process.env.CHROMIUM_FLAGS?.split(" ") ?? [])];

export async function openBrowser() {
  return chromium.launch({ executablePath: CHROMIUM, headless: true, args: FLAGS });
}
