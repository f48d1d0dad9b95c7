#version 330 core
// A soft disc.
in float alpha;

uniform vec3 tint;

layout(location = 0) out vec4 pixel;

void main() {
  vec2 d = 2.0 * gl_PointCoord - 1.0;
  float soft = 1.0 - smoothstep(0.2, 1.0, dot(d, d));
  if (soft * alpha < 0.01) discard;
  pixel = vec4(tint, alpha * soft);
}
