// The Earth's surface in its own frame as cube maps: ground and clouds, and the lights of towns. Tiles are computed when
// they come into view, by the OpenGL renderer's shader, a few each picture.

import * as THREE from "three";
import { FullScreen } from "./full_screen.js";
import { toEs } from "./glsl.js";
import { landTexture, tableTexture } from "./tables.js";

const FACE_PX = 1024, TILE_PX = 128, TILES = FACE_PX / TILE_PX;
const TILES_AT_ONCE = 6;
const EARTH_RADIUS_M = 6371000;

// Centre, right and down of each face in OpenGL's cube map layout.
const FACES = [[[1, 0, 0], [0, 0, -1], [0, -1, 0]], [[-1, 0, 0], [0, 0, 1], [0, -1, 0]],
  [[0, 1, 0], [1, 0, 0], [0, 0, 1]], [[0, -1, 0], [1, 0, 0], [0, 0, -1]],
  [[0, 0, 1], [1, 0, 0], [0, -1, 0]], [[0, 0, -1], [-1, 0, 0], [0, -1, 0]]]
  .map((axes) => axes.map((axis) => new THREE.Vector3(...axis)));

const cube = () => new THREE.WebGLCubeRenderTarget(FACE_PX, { generateMipmaps: false, depthBuffer: false });

export class EarthGround {
  ground = cube();
  lights = cube();
  #open = [];

  constructor(assets, shaders) {
    const uniforms = { u_centre: { value: null }, u_right: { value: null }, u_down: { value: null },
      u_land: { value: landTexture(assets.land) }, u_lights: { value: tableTexture(assets.lights) }, u_clouds: { value: tableTexture(assets.clouds) } };
    uniforms.u_lights.value.wrapS = uniforms.u_clouds.value.wrapS = THREE.RepeatWrapping;
    const vertex = toEs(shaders.earth_vertex);
    this.passes = [["o_color", this.ground], ["o_lights", this.lights]].map(([output, target]) => ({ target,
      shader: new FullScreen({ vertex, fragment: toEs(shaders.earth_fragment, { output }), uniforms }) }));
    this.uniforms = uniforms;
    FACES.forEach((axes, face) => {
      for (let tile = 0; tile < TILES * TILES; ++tile) {
        const [column, row] = [tile % TILES, Math.floor(tile / TILES)];
        const centre = axes[0].clone().addScaledVector(axes[1], (2 * column + 1) / TILES - 1)
          .addScaledVector(axes[2], (2 * row + 1) / TILES - 1).normalize();
        this.#open.push({ face, column, row, centre });
      }
    });
  }

  // A tile is in view when its angle from the point below the eye is at most that of the horizon. Returns how many are
  // left to be computed.
  bake(renderer, eye_E, isWhole) {
    const horizon = Math.acos(Math.min(1, EARTH_RADIUS_M / eye_E.length()));
    const least = Math.cos(Math.min(Math.PI, horizon + Math.SQRT2 / TILES));
    const below = eye_E.clone().normalize();
    const wanted = this.#open.filter(({ centre }) => centre.dot(below) >= least)
      .sort((a, b) => b.centre.dot(below) - a.centre.dot(below));
    const now = new Set(isWhole ? wanted : wanted.slice(0, TILES_AT_ONCE));
    for (const tile of now) this.#bake(renderer, tile);
    this.#open = this.#open.filter((tile) => !now.has(tile));
    return wanted.length - now.size;
  }

  #bake(renderer, { face, column, row }) {
    [this.uniforms.u_centre.value, this.uniforms.u_right.value, this.uniforms.u_down.value] = FACES[face];
    for (const { target, shader } of this.passes) {
      target.scissorTest = true;
      target.scissor.set(column * TILE_PX, row * TILE_PX, TILE_PX, TILE_PX);
      renderer.setRenderTarget(target, face);
      shader.drawBound(renderer);
    }
  }
}
