#version 330 core
// Panels and text, in framebuffer pixels from the top left.
layout(location = 0) in vec2 at_px;
layout(location = 1) in vec2 at_texel;
layout(location = 2) in vec4 tint;

uniform vec2 window_px;
uniform vec2 texture_px;

out vec2 uv;
out vec4 colour;

void main() {
  uv = at_texel / texture_px;
  colour = tint;
  gl_Position = vec4(2.0 * at_px.x / window_px.x - 1.0, 1.0 - 2.0 * at_px.y / window_px.y, 0.0, 1.0);
}
