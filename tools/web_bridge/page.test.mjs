// The page in Chromium: on a live run of scenarios/touch, and on a recording of it.

import assert from "node:assert/strict";
import { once } from "node:events";
import path from "node:path";
import { after, before, test } from "node:test";
import { openBrowser } from "./testing/browser.mjs";
import { compare, viewsOf } from "./testing/compare.mjs";
import { lastingTouch } from "./testing/lasting_touch.mjs";
import { PATIENCE, Processes } from "./testing/processes.mjs";

const DESK = { width: 1280, height: 720 }, PHONE = { width: 390, height: 844 };
const processes = new Processes();
const errors = [];
let browser, live, recording, recorded;

before(async () => {
  [browser, live] = await Promise.all([openBrowser(), processes.startBridge(lastingTouch(processes.folder))]);
  recording = path.join(processes.folder, "touch.mcap");
});
after(async () => {
  await browser?.close();
  await processes.endAll();
});

async function open(address, options = {}) {
  const page = await browser.newPage({ viewport: DESK, ...options });
  page.setDefaultTimeout(180_000);  // a busy machine is late, and a condition that comes ends the wait
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => message.type() === "error" && errors.push(`${message.text()} ${message.location().url ?? ""}`));
  await page.goto(address);
  return page;
}
const opened = async (address, options) => {
  const page = await open(address, options);
  await page.waitForFunction(() => window.page?.frames > 2);
  return page;
};

// Presses again where the page says that a node of a busy machine did not answer in time, or is not there yet, as a
// person would.
async function setUntilAnswered(page, wanted, press) {
  for (let said = ""; said !== wanted;) {
    await page.evaluate(() => { document.getElementById("link").textContent = ""; });
    await press();
    await page.waitForFunction((text) => {
      const now = document.getElementById("link").textContent;
      return now === text || now.endsWith("did not answer in time") || now.includes("no live node is called");
    }, wanted);
    said = await page.evaluate(() => document.getElementById("link").textContent);
  }
}

// What a person sees, as the mean brightness of each cell of a coarse grid.
const grid = (page) => page.evaluate(() => {
  const { picture, control } = window.page;
  picture.draw(control.camera, { width: 320, height: 180, isStill: true });
  const gl = picture.renderer.getContext();
  const pixels = new Uint8Array(320 * 180 * 4);
  gl.readPixels(0, 0, 320, 180, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const cells = new Array(16 * 9).fill(0);
  for (let y = 0; y < 180; ++y) {
    for (let x = 0; x < 320; ++x) cells[Math.floor(y / 20) * 16 + Math.floor(x / 20)] += pixels[4 * (320 * y + x) + 1] / 400;
  }
  return cells;
});

test("the page shows the scenario, starts a session, follows it, plots it, sets parameters, and stops it", PATIENCE, async () => {
  const page = await opened(live.page);
  const cells = await grid(page);
  assert.ok(Math.max(...cells) > 100 && Math.min(...cells) < 60, `one colour: ${cells.join()}`);
  const state = (text) => page.waitForFunction((wanted) => document.getElementById("state").textContent === wanted, text);
  const xOfBall = () => page.evaluate(() => window.page.picture.bodies.instances.find(({ name }) => name === "ball")
    .group.matrix.elements[12]);
  await state("no session runs here");
  const first = await xOfBall();

  await page.locator("#start:enabled").click();
  await state("a session runs");
  const recorder = processes.start(process.env.OOS, ["record", recording, "--seconds", "6"]);
  await page.waitForFunction((x) => Math.abs(window.page.picture.bodies.instances.find(({ name }) => name === "ball")
    .group.matrix.elements[12] - x) > 0.005, first);
  await page.waitForFunction(() => document.querySelectorAll("#hands .plot").length === 1 &&
    document.querySelectorAll("#latency .plot").length === 2 && window.page.latencies.length > 5);
  await page.waitForFunction(() => document.querySelector(".now")?.textContent.length > 2);
  assert.ok((await page.locator("#hud").textContent()).includes("SIMULATED"), "simulated things say so");
  const set = async (name, value) => {
    await page.fill("#parameter-name", name);
    await page.fill("#parameter-value", value);
    await page.click("#parameter button");
  };
  await set("haptic_node.force_cap_N", "-3");
  await page.waitForFunction(() => document.getElementById("link").textContent.includes("force_cap_N"));
  await setUntilAnswered(page, "haptic_node.force_cap_N = 25", () => set("haptic_node.force_cap_N", "25"));
  assert.deepEqual(errors, []);
  if (recorder.exitCode === null) await once(recorder, "exit");
  await page.locator("#stop:enabled").click();
  await state("no session runs here");
  await page.close();
});

test("whoever has no key sees no scene", PATIENCE, async () => {
  for (const address of [live.origin, `${live.origin}/#key=wrong`]) {
    const page = await open(address);
    await page.getByLabel("The session's key").waitFor();
    assert.equal(await page.evaluate(() => window.page?.frames ?? 0), 0, address);
    assert.ok(!(await page.content()).includes("ball"));
    await page.close();
  }
  assert.ok(errors.every((text) => text.includes("401") || text.includes("WebSocket")), errors.join("\n"));
  errors.length = 0;
});

test("a recording is played, paused and sought", PATIENCE, async () => {
  recorded = await processes.startBridge("touch", ["--recording", recording]);
  const page = await opened(recorded.page);
  const duration = await page.evaluate(() => Number(document.getElementById("seek").max));
  assert.ok(duration > 2, `${duration} s`);
  const seek = (s) => page.evaluate((value) => {
    const slider = document.getElementById("seek");
    slider.value = value;
    slider.dispatchEvent(new Event("input"));
    slider.dispatchEvent(new Event("change"));
  }, s);
  const ballAt = async (s) => {
    await seek(s);
    await page.waitForFunction((at) => Math.abs(window.page.frame.atS - at) < 0.02, s);
    return page.evaluate(() => window.page.picture.bodies.instances.find(({ name }) => name === "ball").group.matrix.elements.slice());
  };
  const early = await ballAt(0.5), late = await ballAt(duration - 0.5);
  assert.notDeepEqual(early, late);
  assert.deepEqual(await ballAt(0.5), early, "the same time shows the same");
  await page.locator("#play").click();
  await page.waitForFunction(() => window.page.frame.atS > 1);
  await page.locator("#play").click();
  await page.waitForFunction(() => !window.page.frame.isPlaying);
  await page.close();
  assert.deepEqual(errors, []);
});

test("a person chooses what is shown, selects a part by a click, hides and highlights it", PATIENCE, async () => {
  const page = await opened(recorded.page);
  const choices = (name) => page.waitForFunction((one) => window.page.frame.choices.includes(one), name);
  const offered = await page.locator("#overlays button").allTextContents();
  assert.ok(offered.includes("axes") && !offered.includes("camera"), `no button that does nothing: ${offered}`);
  await page.locator("#overlays button", { hasText: "paths" }).click();
  await choices("overlay.paths");
  await page.keyboard.press("r");
  await page.waitForFunction(() => !window.page.frame.choices.includes("overlay.paths"));
  const at = await page.evaluate(() => {
    const { picture, control } = window.page;
    const p = picture.bodies.instances.find(({ name }) => name === "plate").centre.clone().project(control.camera);
    const box = document.getElementById("view").getBoundingClientRect();
    return { x: box.left + (0.5 + 0.5 * p.x) * box.width, y: box.top + (0.5 - 0.5 * p.y) * box.height };
  });
  await page.mouse.click(at.x, at.y);
  await page.waitForFunction(() => window.page.frame.choices.some((one) => one.startsWith("select.")));
  const name = await page.evaluate(() => window.page.panel.selected);
  await page.locator("#hide").click();
  await choices(`hide.${name}`);
  await page.keyboard.press("/");
  await choices(`highlight.${name}`);
  await page.locator("#show-all").click();
  await page.waitForFunction(() => !window.page.frame.choices.some((one) => one.startsWith("hide.")));
  await page.close();
  assert.deepEqual(errors, []);
});

// Of a scenario that has such a camera. The oracles: the page's own picture of that camera, and the OpenGL renderer's with
// its inset.
test("what a hand's camera sees is in a corner, where the OpenGL renderer has it", PATIENCE, async (t) => {
  const others = new Processes();
  t.after(() => others.endAll());
  const { page: address } = await others.startBridge("module_replacement");
  const page = await opened(address, { viewport: { width: 320, height: 180 } });
  await page.keyboard.press("o");
  await page.waitForFunction(() => window.page.frame.choices.includes("overlay.camera"));
  const { inside, outside, frame } = await page.evaluate(() => {
    const { picture, control } = window.page;
    const [width, height, share] = [640, 360, 4], [w, h] = [width / share, height / share];
    const x0 = width - Math.floor(height / 36) - w, y0 = Math.floor(height / 5);
    const pixelsOf = (camera, size, inset) => {
      picture.draw(camera, { ...size, isStill: true, inset });
      const pixels = new Uint8Array(4 * size.width * size.height), gl = picture.renderer.getContext();
      gl.readPixels(0, 0, size.width, size.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      return pixels;
    };
    const carried = window.page.inset(width / height);
    const alone = pixelsOf(carried, { width: w, height: h });
    control.camera.aspect = width / height;
    control.camera.updateProjectionMatrix();
    const without = pixelsOf(control.camera, { width, height }), whole = pixelsOf(control.camera, { width, height }, carried);
    const isWithin = (x, y, margin) => x >= x0 - margin && x < x0 + w + margin && y >= y0 - margin && y < y0 + h + margin;
    let inside = 0, outside = 0;
    for (let y = 0; y < height; ++y) {
      for (let x = 0; x < width; ++x) {
        const i = 4 * (y * width + x) + 1;  // green
        if (isWithin(x, y, 0)) inside += Math.abs(whole[i] - alone[4 * ((y - y0) * w + x - x0) + 1]);
        else if (!isWithin(x, y, 1)) outside += Math.abs(whole[i] - without[i]);
      }
    }
    const corner = 4 * ((y0 - 1) * width + x0 - 1);
    return { inside: inside / (w * h), outside, frame: [...whole.subarray(corner, corner + 3)] };
  });
  t.diagnostic(`differs by ${inside} of 255 in the inset, by ${outside} outside; frame ${frame}`);
  assert.equal(outside, 0);
  assert.ok(inside < 1, "not what the camera sees");
  assert.deepEqual(frame, [140, 158, 179]);
  if (!process.env.DISPLAY) {
    t.diagnostic("SKIPPED: comparing with the OpenGL renderer needs a display");
  } else {
    // A near view: where the inset is are parts, over which the pictures are compared.
    const views = viewsOf(await page.evaluate(() => ({ cameras: window.page.assets.cameras }))).slice(1, 2);
    const compared = (show) => compare(page, "module_replacement", views,
      { folder: processes.folder, options: ["--show", show] });
    const [inset] = await compared("camera"), [without] = await compared("no_camera");
    t.diagnostic(`FLIP ${inset.flip}; from a picture without the inset ${without.flip}`);
    assert.ok(inset.flip <= 0.10, `FLIP ${inset.flip}`);
    assert.ok(inset.flip + 0.01 < without.flip, "the OpenGL renderer's is elsewhere");
  }
  await page.close();
  assert.deepEqual(errors, []);
});

test("on a phone's screen the picture and the controls are there, and nothing is wider than it", PATIENCE, async () => {
  const page = await opened(recorded.page, { viewport: PHONE, hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
  const box = await page.locator("#view").boundingBox();
  assert.ok(box.width === PHONE.width && box.height > 0.4 * PHONE.height, JSON.stringify(box));
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), PHONE.width);
  for (const id of ["play", "fold"]) assert.ok((await page.locator(`#${id}`).boundingBox()).height >= 30, id);
  const before_ = await page.evaluate(() => window.page.control.camera.position.toArray());
  // One finger turns the view.
  await page.evaluate(async () => {
    const canvas = document.getElementById("view");
    const send = (type, x) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: 7, pointerType: "touch", clientX: x,
      clientY: 200, bubbles: true, isPrimary: true, button: 0 }));
    canvas.setPointerCapture = canvas.releasePointerCapture = () => {};
    send("pointerdown", 100);
    for (let x = 100; x < 200; x += 10) send("pointermove", x);
    send("pointerup", 200);
  });
  await page.waitForFunction((old) => window.page.control.camera.position.toArray().some((value, i) =>
    Math.abs(value - old[i]) > 0.01), before_);
  await page.locator("#fold").click();
  assert.equal(await page.locator("aside").isVisible(), false);
  await page.close();
  assert.deepEqual(errors, []);
});

test("from a phone a finger starts a session, sets a parameter, and stops it", PATIENCE, async () => {
  const page = await opened(live.page, { viewport: PHONE, hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
  const state = (text) => page.waitForFunction((wanted) => document.getElementById("state").textContent === wanted, text);
  await state("no session runs here");
  for (const id of ["start", "stop"]) {
    const { x, width, height } = await page.locator(`#${id}`).boundingBox();
    assert.ok(x >= 0 && x + width <= PHONE.width && height >= 30, `${id}: a finger meets it`);
  }
  await page.locator("#start:enabled").tap();
  await state("a session runs");
  const name = "haptic_node.force_cap_N";
  await page.waitForFunction((one) => [...document.getElementById("parameter-names").options].some(({ value }) => value === one), name);
  await page.fill("#parameter-name", name);
  await page.fill("#parameter-value", "24");
  await setUntilAnswered(page, `${name} = 24`, () => page.locator("#parameter button").tap());
  await page.locator("#stop:enabled").tap();
  await state("no session runs here");
  await page.close();
  assert.deepEqual(errors, []);
});

// A person at the page: mouse and keys of Chromium, eyes on the captions.
test("the page is the hand: dragging moves it as far as the captions say, Space closes the jaws", PATIENCE, async (t) => {
  const others = new Processes();  // the first bridge of this test would join, too, and be the hand
  t.after(() => others.endAll());
  const run = await others.startSession("peg_in_hole", ["--hand", "pointer", "--duration", "600"]);
  const { page: address } = await others.startBridge("peg_in_hole");
  const page = await opened(address);
  await page.waitForFunction(() => window.page.hand.canSteer);
  const caption = () => page.evaluate(() => window.page.frame.texts.map(({ text }) => text).find((text) => text.startsWith("next: ")) ?? "");
  const upwards = (text) => Number(/up ([\d.]+)/.exec(text)?.[1] ?? -Number(/down ([\d.]+)/.exec(text)?.[1] ?? 0));
  await page.mouse.move(640, 300);
  await page.keyboard.press("F2");
  await page.waitForFunction(() => window.page.frame.texts.some(({ text }) => text.startsWith("next: down 18")));
  const before_ = upwards(await caption());
  await page.mouse.down({ button: "right" });
  let isThere = false;
  const there = page.waitForFunction((first) => {
    const text = window.page.frame.texts.map((one) => one.text).find((one) => one.startsWith("next: ")) ?? "";
    return Number(/down ([\d.]+)/.exec(text)?.[1] ?? 0) > 10 - first;
  }, before_).then(() => { isThere = true; });
  // Up by 40 px: the goal is further down by as much. The clutch stays closed until the hand has come; where messages
  // are late it opens, because nobody may be there, and a person drags on.
  for (let from = 300; from >= 60 && !isThere; from -= 40) {
    for (let y = from; y >= from - 40; y -= 5) await page.mouse.move(640, y);
    await Promise.race([there, new Promise((resolve) => setTimeout(resolve, 10_000))]);
  }
  await there;
  assert.ok((await page.evaluate(() => window.page.frame.texts.map(({ text }) => text).join("\n"))).includes("hand right: held"));
  await page.mouse.up({ button: "right" });
  const postures = () => page.evaluate(() => window.page.picture.bodies.meshes.map(({ skin }) => skin?.shown ?? "").join(""));
  const open = await postures();
  assert.notEqual(open, "", "the jaws' cables go with them");
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.page.frame.texts.some(({ text }) => text.startsWith("hand right: free, jaws closing")));
  await page.waitForFunction((old) =>
    window.page.picture.bodies.meshes.map(({ skin }) => skin?.shown ?? "").join("") !== old, open);
  await page.close();
  await others.end(run, "SIGINT");
  assert.deepEqual(errors, []);
});

test("two views look as the OpenGL renderer's, and five hundred pictures leave the memory as it was", PATIENCE, async (t) => {
  const { page: address } = await processes.startBridge("touch");
  const page = await opened(address);
  const tools = await page.context().newCDPSession(page);
  const draw = (number) => page.evaluate(async (times) => {
    const { picture, control, link } = window.page;
    const frames = [];
    for (let i = 0; i < times; ++i) {
      frames[0] = link.decode("SceneFrame", window.page.newestBytes);
      picture.show(frames[0]);
      picture.draw(control.camera, { width: 32, height: 18 });
      if (i % 50 === 0) await new Promise((resolve) => setTimeout(resolve));
    }
  }, number);
  const sample = async () => {
    await tools.send("HeapProfiler.collectGarbage");
    const { usedSize } = await tools.send("Runtime.getHeapUsage");
    return { MB: usedSize / 1e6, ...await page.evaluate(() => ({ ...window.page.picture.renderer.info.memory })) };
  };
  await draw(100);
  const before_ = await sample();
  await draw(500);
  const after_ = await sample();
  t.diagnostic(`${JSON.stringify(before_)}, then ${JSON.stringify(after_)}`);
  assert.ok(after_.MB < before_.MB + 1.5, "the heap grows");
  assert.deepEqual([after_.geometries, after_.textures], [before_.geometries, before_.textures]);
  if (!process.env.DISPLAY) {
    t.diagnostic("SKIPPED: comparing with the OpenGL renderer needs a display");
  } else {
    const views = viewsOf(await page.evaluate(() => ({ cameras: window.page.assets.cameras }))).slice(0, 2);
    const results = await compare(page, "touch", views, { folder: processes.folder, width: 320, height: 180 });
    for (const one of results) {
      t.diagnostic(JSON.stringify(one));
      assert.ok(one.flip <= 0.10 && one.same_ids >= 0.995, JSON.stringify(one));
    }
  }
  await page.close();
  assert.deepEqual(errors, []);
});
