#version 330 core
// Lines, patches and symbols that were projected on the processor: clip coordinates with their depth.
layout(location = 0) in vec3 at_clip;
layout(location = 1) in vec4 tint;       // a: opacity where it is seen
layout(location = 2) in vec4 edge_dash;  // distance from the middle and half width, px; distance along, px; see below

out vec4 colour;
out vec4 edge;

void main() {
  colour = tint;
  edge = edge_dash;
  gl_Position = vec4(at_clip, 1.0);
}
