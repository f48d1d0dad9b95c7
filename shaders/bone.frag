#version 330 core
// Light from the camera's upper left, slightly darker edges, and, with PORES, pores on cancellous faces: distinguishable
// without colour. Software drivers compute both sides of a condition, so what has no pores is drawn without PORES.
in vec3 at_view;
in vec3 normal_view;
in vec4 tint;
#ifdef PORES
in vec3 at_bone;
#endif

uniform vec3 to_eye;       // direction to the eye in view space, used in parallel projection
uniform float parallel;    // 1 or 0
uniform float opacity;     // 1: solid; otherwise the minimum alpha, where the surface faces the eye
uniform float pixel_mm;    // size of a pixel at the camera's target

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
  vec3 eye = parallel > 0.5 ? to_eye : normalize(-at_view);
  vec3 n = normalize(normal_view);
  if (dot(n, eye) < 0.0) n = -n;
  vec3 colour = tint.rgb;
#ifdef PORES
  if (tint.a > 0.5) {
    float pores = smoothstep(0.52, 0.40, Noise(at_bone * 1.9));
    colour *= 1.0 - 0.42 * pores * (1.0 - smoothstep(0.2, 0.5, pixel_mm));
  }
#endif
  const vec3 kLamps[4] = vec3[](vec3(-0.338, 0.474, 0.812), vec3(0.669, 0.0, 0.743), vec3(0.0, 0.0, 1.0),
                                vec3(0.206, -0.927, 0.309));
  const float kPower[4] = float[](0.62, 0.30, 0.20, 0.10);
  float light = 0.22;
  for (int i = 0; i < 4; ++i) light += 0.86 * kPower[i] * max(0.0, dot(n, kLamps[i]));
  float facing = max(0.0, dot(n, eye));
  float edge = mix(0.68, 1.0, smoothstep(0.0, 0.45, facing));
  vec3 half_way = normalize(kLamps[0] + eye);
  float mirrored = max(0.0, dot(n, half_way));
  float shine = mirrored * mirrored;
  shine *= shine * shine;
  shine *= 0.07 * shine * shine;  // 0.07 mirrored^18
  float alpha = opacity >= 1.0 ? 1.0 : mix(0.75, opacity, smoothstep(0.0, 0.7, facing));
  pixel = vec4(colour * light * edge + shine, alpha);
}
