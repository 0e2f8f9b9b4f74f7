#include "client/town/shaders.h"

#include "absl/strings/str_cat.h"

namespace semmap::town::shaders {
namespace {

constexpr char kVersion[] = "#version 450 core\n";

constexpr char kSurfaceVertex[] = R"(
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec2 in_uv;
layout(location = 2) in vec2 in_grime_uv;
layout(location = 3) in vec4 in_normal;
layout(location = 4) in vec4 in_tint;
layout(location = 5) in uvec4 in_ids;    // layer, class, grime, unused

uniform mat4 u_clip_from_town;
uniform mat4 u_town_from_model;
uniform vec4 u_depth_row;                // depth along the optical axis = dot(row, point)
uniform mat4 u_shadow_from_town;         // of what stands still
uniform mat4 u_moving_from_town;         // of what moves
uniform vec3 u_sun;                      // towards it
uniform vec3 u_sun_light;
uniform vec3 u_sky_light;
uniform vec3 u_ground_light;
uniform float u_lamps;                   // how strongly the town's own lights shine
uniform float u_grime_scale;

out vec3 v_uv;
out vec2 v_grime_uv;
out vec3 v_ambient;
out vec3 v_direct;
out vec3 v_glow;
out vec3 v_shadow;
out vec3 v_moving;
out float v_depth;
flat out vec2 v_class_grime;

void main() {
  vec4 town = u_town_from_model * vec4(in_position, 1.0);
  vec3 normal = normalize(mat3(u_town_from_model) * in_normal.xyz);
  gl_Position = u_clip_from_town * town;
  v_depth = dot(u_depth_row, town);
  v_uv = vec3(in_uv, float(in_ids.x));
  v_grime_uv = in_grime_uv * u_grime_scale;
  vec3 tint = in_tint.rgb * in_tint.rgb;
  float up = normal.z * 0.5 + 0.5;
  float bounce = 0.12 * max(0.0, dot(normal.xy, -u_sun.xy));   // light thrown back by the sunny side of the street
  // What lies low in the street sees less of the sky.
  float open = mix(0.72, 1.0, clamp(town.z / 9.0, 0.0, 1.0));
  v_ambient = tint * (mix(u_ground_light, u_sky_light, up) * open + bounce * u_sun_light);
  v_direct = tint * u_sun_light * max(0.0, dot(normal, u_sun));
  v_glow = tint * in_tint.a * u_lamps;
  vec4 lifted = vec4(town.xyz + normal * 0.06, 1.0);
  v_shadow = (u_shadow_from_town * lifted).xyz;
  v_moving = (u_moving_from_town * lifted).xyz;
  v_class_grime = vec2(float(in_ids.y) / 255.0, float(in_ids.z) / 255.0);
}
)";

constexpr char kSurfaceFragment[] = R"(
in vec3 v_uv;
in vec2 v_grime_uv;
in vec3 v_ambient;
in vec3 v_direct;
in vec3 v_glow;
in vec3 v_shadow;
in vec3 v_moving;
in float v_depth;
flat in vec2 v_class_grime;

layout(binding = 0) uniform sampler2DArray u_layers;
layout(binding = 1) uniform sampler2D u_grime;
layout(binding = 2) uniform sampler2DShadow u_shadows;
layout(binding = 3) uniform sampler2DShadow u_moving_shadows;
uniform vec3 u_fog;
uniform float u_fog_density;
uniform float u_moving_on;

layout(location = 0) out vec4 out_colour;   // A: class
layout(location = 1) out float out_depth;

void main() {
  vec4 texel = texture(u_layers, v_uv);
#ifdef CUT_OUT
  float cover = texel.a;
  if (cover < 0.2) discard;
#ifdef SAMPLES
  gl_SampleMask[0] = cover > 0.8 ? 15 : cover > 0.6 ? 7 : cover > 0.4 ? 5 : 1;
#else
  if (cover < 0.5) discard;
#endif
#endif
  vec2 grime = texture(u_grime, v_grime_uv).rg - 0.5;
  float stain = clamp(1.0 + v_class_grime.y * (1.25 * grime.x + 0.95 * grime.y), 0.3, 1.7);
  vec3 albedo = texel.rgb * texel.rgb * stain;
  float lit = 0.0;
  if (v_direct.r + v_direct.g + v_direct.b > 0.001) {
    lit = texture(u_shadows, v_shadow);
    if (u_moving_on > 0.5) lit *= texture(u_moving_shadows, v_moving);
  }
  vec3 light = albedo * (v_ambient + v_direct * lit) + texel.rgb * texel.rgb * v_glow;
  float fog = 1.0 - exp(-u_fog_density * v_depth);
  light = mix(light, u_fog, fog);
  out_colour = vec4(sqrt(light / (1.0 + 0.25 * light)), v_class_grime.x);
  out_depth = v_depth;
}
)";

constexpr char kShadowVertex[] = R"(
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec2 in_uv;
layout(location = 5) in uvec4 in_ids;
uniform mat4 u_clip_from_town;
uniform mat4 u_town_from_model;
out vec3 v_uv;
void main() {
  gl_Position = u_clip_from_town * u_town_from_model * vec4(in_position, 1.0);
  v_uv = vec3(in_uv, float(in_ids.x));
}
)";

constexpr char kShadowFragment[] = R"(
in vec3 v_uv;
layout(binding = 0) uniform sampler2DArray u_layers;
void main() {
#ifdef CUT_OUT
  if (texture(u_layers, v_uv).a < 0.4) discard;
#endif
}
)";

constexpr char kSkyVertex[] = R"(
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec2 in_uv;
layout(location = 5) in uvec4 in_ids;
uniform mat4 u_clip_from_town;
uniform vec3 u_eye;
out vec3 v_uv;
out float v_up;
void main() {
  gl_Position = (u_clip_from_town * vec4(in_position * 100.0 + u_eye, 1.0)).xyww;
  v_uv = vec3(in_uv, float(in_ids.x));
  v_up = in_position.z;
}
)";

constexpr char kSkyFragment[] = R"(
in vec3 v_uv;
in float v_up;
layout(binding = 0) uniform sampler2DArray u_layers;
uniform vec3 u_sky_tint;
uniform float u_clouds;      // 0: as painted, 1: covered
uniform vec3 u_fog;
layout(location = 0) out vec4 out_colour;
layout(location = 1) out float out_depth;
void main() {
  vec3 texel = texture(u_layers, v_uv).rgb;
  texel = texel * texel;
  float grey = dot(texel, vec3(0.3, 0.5, 0.2));
  vec3 sky = mix(texel, vec3(0.45 + 0.5 * grey), u_clouds) * u_sky_tint;
  sky = mix(u_fog, sky, smoothstep(0.0, 0.22, v_up));
  out_colour = vec4(sqrt(sky / (1.0 + 0.25 * sky)), 13.0 / 255.0);
  out_depth = 0.0;
}
)";

constexpr char kSensorVertex[] = R"(
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

constexpr char kSensorFragment[] = R"(
layout(binding = 4) uniform sampler2DMS u_colour;
layout(binding = 5) uniform sampler2DMS u_depth;
uniform vec2 u_size;
uniform float u_exposure;
uniform float u_vignetting;
uniform float u_noise;      // standard deviation at middle grey, of 1
uniform uint u_frame;

layout(location = 0) out vec4 out_colour;
layout(location = 1) out float out_depth;

uint Mix(uint x) {
  x ^= x >> 16; x *= 0x7feb352du; x ^= x >> 15; x *= 0x846ca68bu; x ^= x >> 16;
  return x;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 samples[SAMPLES];
  float depths[SAMPLES];
  vec3 sum = vec3(0.0);
  bool same = true;
  for (int i = 0; i < SAMPLES; ++i) {
    samples[i] = texelFetch(u_colour, pixel, i);
    depths[i] = texelFetch(u_depth, pixel, i).r;
    sum += samples[i].rgb;
    same = same && samples[i].a == samples[0].a && abs(depths[i] - depths[0]) < 0.02 * depths[0];
  }
  // Class and depth are those of the surface that covers most of the pixel.
  int best = 0;
  if (!same) {
    int most = 0;
    for (int i = 0; i < SAMPLES; ++i) {
      int alike = 0;
      for (int k = 0; k < SAMPLES; ++k) {
        if (samples[k].a == samples[i].a && abs(depths[k] - depths[i]) < 0.05 * depths[i] + 0.001) ++alike;
      }
      if (alike > most) { most = alike; best = i; }
    }
  }
  vec3 colour = sum / float(SAMPLES);
  vec2 off = (gl_FragCoord.xy / u_size - 0.5) * 2.0;
  float exposure = u_exposure * (1.0 - u_vignetting * 0.5 * dot(off, off));
  colour *= sqrt(exposure);
  if (u_noise > 0.0) {
    uint h = Mix(uint(pixel.x) + 8192u * uint(pixel.y) + Mix(u_frame));
    vec4 u = vec4(h & 255u, (h >> 8) & 255u, (h >> 16) & 255u, h >> 24) / 255.0;
    float grain = (u.x + u.y + u.z + u.w - 2.0) * 1.73;
    vec3 chroma = u.xyz - 0.5;
    colour += u_noise * (grain + chroma) * (0.4 + 0.6 * sqrt(colour));
  }
  out_colour = vec4(clamp(colour, 0.0, 1.0), samples[best].a);
  out_depth = depths[best];
}
)";

std::string Cut(bool cut_out) { return cut_out ? "#define CUT_OUT\n#define SAMPLES\n" : ""; }

}  // namespace

std::string SurfaceVertex() { return absl::StrCat(kVersion, kSurfaceVertex); }
std::string SurfaceFragment(bool cut_out) { return absl::StrCat(kVersion, Cut(cut_out), kSurfaceFragment); }
std::string ShadowVertex() { return absl::StrCat(kVersion, kShadowVertex); }
std::string ShadowFragment(bool cut_out) { return absl::StrCat(kVersion, Cut(cut_out), kShadowFragment); }
std::string SkyVertex() { return absl::StrCat(kVersion, kSkyVertex); }
std::string SkyFragment() { return absl::StrCat(kVersion, kSkyFragment); }
std::string SensorVertex() { return absl::StrCat(kVersion, kSensorVertex); }
std::string SensorFragment(int samples) {
  return absl::StrCat(kVersion, "#define SAMPLES ", samples, "\n", kSensorFragment);
}

}  // namespace semmap::town::shaders
