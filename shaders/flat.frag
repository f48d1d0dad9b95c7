#version 330 core
in vec2 uv;
in vec4 colour;

uniform sampler2D words;   // alpha of text, or an image
uniform int kind;          // 0: plain, 1: text, 2: image

layout(location = 0) out vec4 pixel;

void main() {
  if (kind == 1) {
    pixel = vec4(colour.rgb, colour.a * texture(words, uv).r);
  } else if (kind == 2) {
    pixel = vec4(texture(words, uv).rgb, colour.a);
  } else {
    pixel = colour;
  }
}
