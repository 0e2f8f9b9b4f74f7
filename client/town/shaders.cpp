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
layout(location = 5) in uvec4 in_ids;    // layer, class, grime, sun

uniform mat4 u_clip_from_town;
uniform mat4 u_town_from_model;
uniform mat4 u_shadow_from_town;
uniform vec3 u_sun;                      // towards it
uniform vec3 u_sun_light;
uniform vec3 u_sky_light;
uniform vec3 u_ground_light;
uniform float u_lamps;                   // how strongly the town's own lights shine
uniform float u_grime_scale;

out vec2 v_uv;
out vec2 v_grime_uv;
out vec3 v_ambient;
#ifdef SHADOW
out vec3 v_shadow;
#endif
// Faces are flat and of one tint, so these are the same over all of a triangle.
flat out vec3 v_direct;
flat out vec3 v_layer_class_grime;

void main() {
  vec4 town = u_town_from_model * vec4(in_position, 1.0);
  vec3 normal = normalize(mat3(u_town_from_model) * in_normal.xyz);
  gl_Position = u_clip_from_town * town;
  v_uv = in_uv;
  v_grime_uv = in_grime_uv * u_grime_scale;
  vec3 tint = in_tint.rgb * in_tint.rgb;
  float up = normal.z * 0.5 + 0.5;
  float bounce = 0.12 * max(0.0, dot(normal.xy, -u_sun.xy));   // light thrown back by the sunny side of the street
  // What lies low in the street sees less of the sky.
  float open = mix(0.72, 1.0, clamp(town.z / 9.0, 0.0, 1.0));
  v_ambient = tint * (mix(u_ground_light, u_sky_light, up) * open + bounce * u_sun_light + in_tint.a * u_lamps);
  v_direct = in_ids.w == 0u ? vec3(0.0) : tint * u_sun_light * max(0.0, dot(normal, u_sun));
#ifdef SHADOW
  vec4 lifted = vec4(town.xyz + normal * 0.06, 1.0);
  v_shadow = (u_shadow_from_town * lifted).xyz;
#endif
  v_layer_class_grime = vec3(float(in_ids.x), float(in_ids.y) / 255.0, float(in_ids.z) / 255.0);
}
)";

constexpr char kSurfaceFragment[] = R"(
in vec2 v_uv;
in vec2 v_grime_uv;
in vec3 v_ambient;
#ifdef SHADOW
in vec3 v_shadow;
#endif
flat in vec3 v_direct;
flat in vec3 v_layer_class_grime;

layout(binding = 0) uniform sampler2DArray u_layers;
layout(binding = 1) uniform sampler2D u_grime;
layout(binding = 2) uniform sampler2DShadow u_shadows;
uniform vec3 u_fog;
uniform float u_fog_density;

layout(location = 0) out vec4 out_colour;   // A: class

void main() {
  vec4 texel = texture(u_layers, vec3(v_uv, v_layer_class_grime.x));
#ifdef CUT_OUT
  if (texel.a < 0.45) discard;
  float stain = 1.0;
#else
  vec2 grime = texture(u_grime, v_grime_uv).rg - 0.5;
  float stain = clamp(1.0 + v_layer_class_grime.z * (1.25 * grime.x + 0.95 * grime.y), 0.3, 1.7);
#endif
  float lit = 1.0;
#ifdef SHADOW
  lit = texture(u_shadows, v_shadow);
#endif
  vec3 light = texel.rgb * texel.rgb * stain * (v_ambient + v_direct * lit);
  float fog = 1.0 - exp(-u_fog_density / gl_FragCoord.w);
  light = mix(light, u_fog, fog);
  out_colour = vec4(sqrt(light / (1.0 + 0.25 * light)), v_layer_class_grime.y);
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
void main() {
  vec3 texel = texture(u_layers, v_uv).rgb;
  texel = texel * texel;
  float grey = dot(texel, vec3(0.3, 0.5, 0.2));
  vec3 sky = mix(texel, vec3(0.45 + 0.5 * grey), u_clouds) * u_sky_tint;
  sky = mix(u_fog, sky, smoothstep(0.0, 0.22, v_up));
  out_colour = vec4(sqrt(sky / (1.0 + 0.25 * sky)), 13.0 / 255.0);
}
)";

constexpr char kSensorVertex[] = R"(
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

constexpr char kSensorFragment[] = R"(
layout(binding = 4) uniform sampler2D u_colour;   // A: class
layout(binding = 5) uniform sampler2D u_depth;
uniform vec2 u_size;
uniform vec2 u_near_far;
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

float Luma(vec3 colour) { return dot(colour, vec3(0.3, 0.6, 0.1)); }

// Smooths the stairs of edges by looking along them (Lottes, FXAA, 2009): the brightness at the pixel's corners
// tells how the edge runs. What is left of the corners is the blur of a lens.
vec3 Smooth(vec3 middle) {
  vec2 at = gl_FragCoord.xy / u_size;
  vec2 step = 0.5 / u_size;
  vec3 nw = textureLod(u_colour, at + vec2(-step.x, step.y), 0.0).rgb;
  vec3 ne = textureLod(u_colour, at + step, 0.0).rgb;
  vec3 sw = textureLod(u_colour, at - step, 0.0).rgb;
  vec3 se = textureLod(u_colour, at + vec2(step.x, -step.y), 0.0).rgb;
  vec4 corner = vec4(Luma(nw), Luma(ne), Luma(sw), Luma(se));
  vec2 along = vec2(corner.z + corner.w - corner.x - corner.y, corner.x + corner.z - corner.y - corner.w);
  float steepest = max(abs(along.x), abs(along.y));
  float flattest = min(abs(along.x), abs(along.y));
  // Edges close to a row or column have long stairs.
  along *= clamp(1.0 / (flattest + 0.02 + 0.1 * steepest), 0.0, 4.0 / (steepest + 1e-4));
  vec2 reach = along * step;
  vec3 wide = 0.5 * (textureLod(u_colour, at + reach, 0.0).rgb + textureLod(u_colour, at - reach, 0.0).rgb);
  vec3 lens = 0.5 * middle + 0.125 * (nw + ne + sw + se);
  return mix(lens, wide, smoothstep(0.08, 0.24, steepest));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 seen = texelFetch(u_colour, pixel, 0);
  float window = texelFetch(u_depth, pixel, 0).r;
  float inverse = 1.0 / u_near_far.x - window * (1.0 / u_near_far.x - 1.0 / u_near_far.y);
  vec3 colour = Smooth(seen.rgb);
  vec2 off = (gl_FragCoord.xy / u_size - 0.5) * 2.0;
  float exposure = u_exposure * (1.0 - u_vignetting * 0.5 * dot(off, off));
  colour *= sqrt(exposure);
  uint h = Mix(uint(pixel.x) + 8192u * uint(pixel.y) + Mix(u_frame));
  vec4 u = vec4(h & 255u, (h >> 8) & 255u, (h >> 16) & 255u, h >> 24) / 255.0;
  float grain = (u.x + u.y + u.z + u.w - 2.0) * 1.73;
  colour += u_noise * (grain + u.xyz - 0.5) * (0.4 + 0.6 * colour);
  out_colour = vec4(clamp(colour, 0.0, 1.0), seen.a);
  out_depth = inverse > 1.01 / u_near_far.y ? 1.0 / inverse : 0.0;
}
)";

std::string Defines(bool cut_out, bool shadow) {
  return absl::StrCat(kVersion, cut_out ? "#define CUT_OUT\n" : "", shadow ? "#define SHADOW\n" : "");
}

}  // namespace

std::string SurfaceVertex(bool shadow) { return Defines(false, shadow) + kSurfaceVertex; }
std::string SurfaceFragment(bool cut_out, bool shadow) { return Defines(cut_out, shadow) + kSurfaceFragment; }
std::string ShadowVertex() { return absl::StrCat(kVersion, kShadowVertex); }
std::string ShadowFragment(bool cut_out) { return Defines(cut_out, false) + kShadowFragment; }
std::string SkyVertex() { return absl::StrCat(kVersion, kSkyVertex); }
std::string SkyFragment() { return absl::StrCat(kVersion, kSkyFragment); }
std::string SensorVertex() { return absl::StrCat(kVersion, kSensorVertex); }
std::string SensorFragment() { return absl::StrCat(kVersion, kSensorFragment); }

}  // namespace semmap::town::shaders
