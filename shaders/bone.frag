#version 330 core
// The shaded surface and, with PORES, pores on cancellous faces: distinguishable without colour. Software drivers
// compute both sides of a condition, so what has no pores is drawn without PORES.
in vec4 shaded;
#ifdef PORES
in vec3 at_bone;
in float shine;
in float porous;

uniform float pixel_mm;  // size of a pixel at the camera's target
#endif

layout(location = 0) out vec4 pixel;

#ifdef PORES
float Hash(vec3 cell) {
  uvec3 u = uvec3(ivec3(cell) + 4096);
  uint h = u.x * 1664525u + u.y * 22695477u + u.z * 1103515245u;
  h ^= h >> 15;
  h *= 2246822519u;
  h ^= h >> 13;
  return float(h & 0xffffu) / 65535.0;
}

float Noise(vec3 p) {
  vec3 cell = floor(p);
  vec3 f = p - cell;
  f = f * f * (3.0 - 2.0 * f);
  vec4 near = vec4(Hash(cell), Hash(cell + vec3(1, 0, 0)), Hash(cell + vec3(0, 1, 0)), Hash(cell + vec3(1, 1, 0)));
  vec4 far = vec4(Hash(cell + vec3(0, 0, 1)), Hash(cell + vec3(1, 0, 1)), Hash(cell + vec3(0, 1, 1)),
                  Hash(cell + vec3(1, 1, 1)));
  vec4 z = mix(near, far, f.z);
  return mix(mix(z.x, z.y, f.x), mix(z.z, z.w, f.x), f.y);
}
#endif

void main() {
  pixel = shaded;
#ifdef PORES
  if (porous > 0.5) {
    float pores = smoothstep(0.52, 0.40, Noise(at_bone * 1.9));
    float kept = 1.0 - 0.42 * pores * (1.0 - smoothstep(0.2, 0.5, pixel_mm));
    pixel.rgb = mix(vec3(shine), shaded.rgb, kept);
  }
#endif
}
