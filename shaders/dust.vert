#version 330 core
// Grains of bone dust as points.
layout(location = 0) in vec3 p_mm;
layout(location = 1) in vec2 size_alpha;  // diameter in mm, opacity

uniform mat4 view_from_world;
uniform mat4 clip_from_view;
uniform float px_per_mm;  // at the depth 1 in perspective, everywhere in parallel projection
uniform float parallel;   // 1 or 0
uniform vec2 size_px;     // smallest and largest diameter

out float alpha;

void main() {
  vec4 at = view_from_world * vec4(p_mm, 1.0);
  float px = size_alpha.x * px_per_mm / (parallel > 0.5 ? 1.0 : max(-at.z, 0.001));
  gl_PointSize = clamp(px, size_px.x, size_px.y);
  alpha = size_alpha.y;
  gl_Position = clip_from_view * at;
}
