#version 330 core
// Drawn twice: where it is seen, and where something lies in front of it.
in vec4 colour;
in vec4 edge;  // x: distance from the middle, y: half width, z: distance along, all in px; w: opacity where it is hidden,
               // negative for a dashed line

uniform float hidden;   // 1 in the pass for what is hidden, else 0
uniform float dash_px;  // length of a dash and its gap

layout(location = 0) out vec4 pixel;

void main() {
  float alpha = hidden > 0.5 ? abs(edge.w) : colour.a;
  alpha *= clamp(edge.y + 0.5 - abs(edge.x), 0.0, 1.0);
  if (hidden > 0.5 && edge.w < 0.0 && fract(edge.z / dash_px) > 0.58) alpha = 0.0;
  if (alpha < 0.004) discard;
  pixel = vec4(colour.rgb, alpha);
}
