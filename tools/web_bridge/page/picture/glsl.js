// The OpenGL renderer's shaders, from GLSL 4.5 to that of WebGL 2 (GLSL ES 3.00), which lacks locations and bindings of
// uniforms, a second source colour for blending, and borders of textures.

const HEAD = "precision highp float;\nprecision highp int;\nprecision highp sampler2DShadow;\nprecision highp sampler3D;\n";

// Static and moving casters have a map each, because copying one is dear without a GPU. Outside of both the sun shines.
const SHADOW = `
uniform sampler2DShadow u_shadow_of_static;
float ShadowOf(vec3 s) {
  vec2 inside = step(vec2(0.0), s.xy) * step(s.xy, vec2(1.0));
  vec3 at = vec3(s.xy, min(s.z, 1.0));
  return mix(1.0, texture(u_shadow, at) * texture(u_shadow_of_static, at), inside.x * inside.y);
}
`;

// `output`: of several outputs the one that is kept; the others become variables. `model`: the uniform that is an object's
// matrix, which three.js sets.
export function toEs(text, { defines = [], output = null, model = null } = {}) {
  let es = text.replace(/#version.*\n/, "")
    .replace(/layout\((?:location|binding) = \d+\) uniform/g, "uniform")
    .replace(/texture\(u_shadow, /g, "ShadowOf(");
  if (output) {
    es = es.replace(/layout\(location = \d+(?:, index = \d+)?\) out (\w+) (\w+);/g,
      (_, type, name) => (name === output ? `layout(location = 0) out ${type} ${name};` : `${type} ${name};`));
  }
  if (model) es = es.replace(new RegExp(`\\b${model}\\b`, "g"), "modelMatrix");
  if (es.includes("ShadowOf(")) es = es.replace(/(uniform sampler2DShadow u_shadow;\n)/, `$1${SHADOW}`);
  return HEAD + defines.map((name) => `#define ${name}\n`).join("") + es;
}
