#version 330 core
// The bone's surface. A vertex stores the region below it and whether the bone was cut there. The palette holds the
// colours, so that a different colouring needs no new vertices. Light comes from the camera's upper left, and edges are
// slightly darker. Both are computed here: a triangle is only a few pixels large, and a software driver shades whole
// blocks of pixels for each. BoneProp inserts the lamps after the first line: kLamps and kPower.
layout(location = 0) in vec3 position;  // whole numbers of units from the bone's origin
layout(location = 1) in vec3 normal;
layout(location = 2) in uvec2 region_cut;

layout(std140) uniform Palette {
  vec4 colour[512];  // by region; entries from 256 on are for cut faces; a: strength of the pores
};
uniform float unit_mm;
uniform mat4 view_from_bone;
uniform mat4 clip_from_view;
uniform vec3 to_eye;     // direction to the eye in view space, used in parallel projection
uniform float parallel;  // 1 or 0
uniform float opacity;   // 1: solid; otherwise the minimum alpha, where the surface faces the eye

out vec4 shaded;
#ifdef PORES
out vec3 at_bone;
out float shine;  // included in `shaded`, but pores do not darken it
out float porous;
#endif

void main() {
  vec3 p_mm = unit_mm * position;
  vec4 at = view_from_bone * vec4(p_mm, 1.0);
  vec3 eye = parallel > 0.5 ? to_eye : normalize(-at.xyz);
  vec3 n = normalize(mat3(view_from_bone) * normal);
  if (dot(n, eye) < 0.0) n = -n;
  float light = 0.22;
  for (int i = 0; i < 4; ++i) light += 0.86 * kPower[i] * max(0.0, dot(n, kLamps[i]));
  float facing = max(0.0, dot(n, eye));
  float edge = mix(0.68, 1.0, smoothstep(0.0, 0.45, facing));
  float mirrored = max(0.0, dot(n, normalize(kLamps[0] + eye)));
  float shiny = mirrored * mirrored;
  shiny *= shiny * shiny;
  shiny *= 0.07 * shiny * shiny;  // 0.07 mirrored^18
  vec4 tint = colour[region_cut.x + (region_cut.y > 127u ? 256u : 0u)];
  float alpha = opacity >= 1.0 ? 1.0 : mix(0.75, opacity, smoothstep(0.0, 0.7, facing));
  shaded = vec4(tint.rgb * light * edge + shiny, alpha);
#ifdef PORES
  at_bone = p_mm;
  shine = shiny;
  porous = tint.a;
#endif
  gl_Position = clip_from_view * at;
}
