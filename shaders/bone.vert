#version 330 core
// The bone's surface. A vertex stores the region below it and whether the bone was cut there. The palette holds the
// colours, so that a different colouring needs no new vertices.
layout(location = 0) in vec3 p_mm;
layout(location = 1) in vec3 normal;
layout(location = 2) in uvec2 region_cut;

layout(std140) uniform Palette {
  vec4 colour[512];  // by region; entries from 256 on are for cut faces; a: strength of the pores
};
uniform mat4 view_from_bone;
uniform mat4 clip_from_view;

out vec3 at_view;
out vec3 normal_view;
out vec3 at_bone;
out vec4 tint;

void main() {
  vec4 at = view_from_bone * vec4(p_mm, 1.0);
  at_view = at.xyz;
  normal_view = mat3(view_from_bone) * normal;
  at_bone = p_mm;
  tint = colour[region_cut.x + (region_cut.y > 127u ? 256u : 0u)];
  gl_Position = clip_from_view * at;
}
