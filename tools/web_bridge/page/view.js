// The scene in WebGL: plain shading, one light. Dragging turns about the scenario's target, the wheel zooms.

const VERTEX = `#version 300 es
in vec3 p_M; in vec3 n_M;
uniform mat4 clip_W; uniform mat4 X_WM;
out vec3 n_W;
void main() { n_W = mat3(X_WM) * n_M; gl_Position = clip_W * (X_WM * vec4(p_M, 1.0)); }`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 n_W; uniform vec3 color; uniform vec3 sun; uniform float glow; out vec4 shown;
void main() {
  float light = 0.42 + 0.25 * normalize(n_W).z + 0.5 * max(dot(normalize(n_W), sun), 0.0);
  shown = vec4(color * mix(clamp(light, 0.12, 1.15), 1.0, glow), 1.0);
}`;

// A 4x4 matrix from a pose, in column order as WebGL expects.
function matrixOf([w, x, y, z, px, py, pz]) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0,
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0, px, py, pz, 1];
}
const minus = (a, b) => a.map((value, i) => value - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((value) => value / Math.hypot(...a));

// For flat shading: each triangle has its own three corners, with the triangle's normal.
function corners({ positions, indices }) {
  const at = (i) => positions.slice(3 * i, 3 * i + 3);
  const out = [];
  for (let t = 0; t < indices.length; t += 3) {
    const [a, b, c] = [at(indices[t]), at(indices[t + 1]), at(indices[t + 2])];
    const normal = cross(minus(b, a), minus(c, a));
    const length = Math.hypot(...normal) || 1;
    for (const p of [a, b, c]) out.push(...p, ...normal.map((value) => value / length));
  }
  return new Float32Array(out);
}

export class View {
  // Null without a scene or without WebGL; the rest of the page works without it.
  static async create(canvas, scene) {
    const gl = scene && canvas.getContext("webgl2", { antialias: true });
    return gl ? new View(canvas, gl, scene) : null;
  }

  constructor(canvas, gl, scene) {
    Object.assign(this, { canvas, gl, scene });
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    this.place = (name) => gl.getUniformLocation(program, name);
    this.attributes = ["p_M", "n_M"].map((name) => gl.getAttribLocation(program, name));
    this.meshes = scene.meshes.map((parts) => parts.map((part) => this.#upload(part)));
    this.sheets = [];
    const camera = scene.cameras[0] ?? { eye_m: [0, -1, 1], target_m: [0, 0, 0], vertical_fov_rad: 0.8 };
    const away = minus(camera.eye_m, camera.target_m);
    this.camera = { target: camera.target_m, fov: camera.vertical_fov_rad, distance: Math.hypot(...away),
      azimuth: Math.atan2(away[1], away[0]), height: Math.asin(away[2] / Math.hypot(...away)) };
    canvas.addEventListener("pointermove", (event) => this.#turn(event));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera.distance *= Math.exp(0.001 * event.deltaY);
      this.#redraw();
    }, { passive: false });
    this.poses = scene.objects.map((object) => object.X_WO);
    this.lamps = new Map();
    new ResizeObserver(() => this.#redraw()).observe(canvas);
  }

  // Draws with the next frame; called only when something has changed.
  #redraw() {
    this.frame ??= requestAnimationFrame(() => {
      this.frame = null;
      this.#draw();
    });
  }

  show({ poses, lamps, sheets }) {
    this.poses = poses;
    this.lamps = new Map(lamps);
    this.sheets = sheets.map((sheet, i) => this.#upload(sheet, this.sheets[i]));
    this.#redraw();
  }

  // Reuses the buffers of an earlier part if there is one.
  #upload(part, { array, buffer } = {}) {
    const { gl } = this;
    const data = corners(part);
    const isNew = !array;
    if (isNew) [array, buffer] = [gl.createVertexArray(), gl.createBuffer()];
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    if (isNew) {
      this.attributes.forEach((attribute, i) => {
        gl.enableVertexAttribArray(attribute);
        gl.vertexAttribPointer(attribute, 3, gl.FLOAT, false, 24, 12 * i);
      });
    }
    return { array, buffer, count: data.length / 6, color: part.base_color };
  }

  #turn({ buttons, movementX, movementY }) {
    if (!buttons) return;
    this.camera.azimuth -= 0.006 * movementX;
    this.camera.height = Math.min(1.5, Math.max(-1.5, this.camera.height + 0.006 * movementY));
    this.#redraw();
  }

  // Clip matrix clip_W of the camera: view direction towards its target, z of W up.
  #clip() {
    const { target, fov, distance, azimuth, height } = this.camera;
    const back = [Math.cos(height) * Math.cos(azimuth), Math.cos(height) * Math.sin(azimuth), Math.sin(height)];
    const right = unit(cross([0, 0, 1], back));
    const up = cross(back, right);
    const eye = target.map((value, i) => value + distance * back[i]);
    const f = 1 / Math.tan(fov / 2), aspect = this.canvas.width / this.canvas.height;
    const near = 0.02 * distance, far = 50 * distance;
    const a = (far + near) / (near - far), b = (2 * far * near) / (near - far);
    const rows = [[...right.map((v) => v * f / aspect), -dot(right, eye) * f / aspect],
      [...up.map((v) => v * f), -dot(up, eye) * f],
      [...back.map((v) => v * a), -dot(back, eye) * a + b], [...back.map((v) => -v), dot(back, eye)]];
    return [0, 1, 2, 3].flatMap((column) => rows.map((line) => line[column]));
  }

  #draw() {
    const { gl, canvas } = this;
    canvas.width = canvas.clientWidth * devicePixelRatio;
    canvas.height = canvas.clientHeight * devicePixelRatio;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0.045, 0.055, 0.07, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix4fv(this.place("clip_W"), false, this.#clip());
    gl.uniform3fv(this.place("sun"), unit([0.3, -0.4, 0.85]));
    this.scene.objects.forEach((object, i) => {
      const color = this.lamps.get(i) ?? object.base_color;
      for (const part of this.meshes[object.mesh] ?? []) this.#drawPart(part, this.poses[i], color, this.lamps.has(i));
    });
    for (const sheet of this.sheets) this.#drawPart(sheet, [1, 0, 0, 0, 0, 0, 0]);
  }

  #drawPart({ array, count, color }, X_WM, givenColor, isLamp = false) {
    const { gl } = this;
    gl.uniformMatrix4fv(this.place("X_WM"), false, matrixOf(X_WM));
    gl.uniform1f(this.place("glow"), isLamp ? 1 : 0);
    gl.uniform3fv(this.place("color"), givenColor ?? color);
    gl.bindVertexArray(array);
    gl.drawArrays(gl.TRIANGLES, 0, count);
  }
}
