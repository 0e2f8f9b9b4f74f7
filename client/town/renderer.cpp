#include "client/town/renderer.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <opencv2/imgproc.hpp>

#include "client/town/egl_context.h"
#include "client/town/frame_target.h"
#include "client/town/gl_objects.h"
#include "client/town/gpu_mesh.h"
#include "client/town/landscape.h"
#include "client/town/shaders.h"
#include "client/town/sun_states.h"
#include "client/town/textures.h"
#include "slam/common/status_macros.h"

namespace semmap::town {
namespace {

constexpr float kNear = 0.2F;
constexpr float kFar = 900.0F;
constexpr float kChunk = 27.0F;
constexpr float kMovingShadowReach = 45.0F;  // metres around the camera
constexpr float kCasterReach = 5.2F;         // metres around the origin of what moves
constexpr float kTallestCaster = 3.0F;       // metres, of what moves

struct SurfaceProgram {
  GlProgram program;
  GLint Location(const char* name) const { return glGetUniformLocation(program.get(), name); }
  void Set(const char* name, const glm::mat4& value) const {
    glProgramUniformMatrix4fv(program.get(), Location(name), 1, GL_FALSE, glm::value_ptr(value));
  }
  void Set(const char* name, const glm::vec4& value) const {
    glProgramUniform4fv(program.get(), Location(name), 1, glm::value_ptr(value));
  }
  void Set(const char* name, const glm::vec3& value) const {
    glProgramUniform3fv(program.get(), Location(name), 1, glm::value_ptr(value));
  }
  void Set(const char* name, const glm::vec2& value) const {
    glProgramUniform2fv(program.get(), Location(name), 1, glm::value_ptr(value));
  }
  void Set(const char* name, float value) const { glProgramUniform1f(program.get(), Location(name), value); }
  void Set(const char* name, uint32_t value) const {
    glProgramUniform1ui(program.get(), Location(name), value);
  }
};

absl::Status Load(const std::string& vertex, const std::string& fragment, SurfaceProgram* program) {
  SEMMAP_ASSIGN_OR_RETURN(program->program, MakeProgram(vertex, fragment));
  return absl::OkStatus();
}

GlTexture UploadLayers(const std::vector<cv::Mat>& layers) {
  GlTexture texture = MakeTexture(GL_TEXTURE_2D_ARRAY);
  const int levels = 1 + static_cast<int>(std::log2(kTextureSize));
  glTextureStorage3D(texture.get(), levels, GL_RGBA8, kTextureSize, kTextureSize,
                     static_cast<GLsizei>(layers.size()));
  for (size_t i = 0; i < layers.size(); ++i) {
    cv::Mat upright;
    cv::flip(layers[i], upright, 0);  // texture coordinates grow upwards
    glTextureSubImage3D(texture.get(), 0, 0, 0, static_cast<GLint>(i), kTextureSize, kTextureSize, 1, GL_RGBA,
                        GL_UNSIGNED_BYTE, upright.data);
  }
  glGenerateTextureMipmap(texture.get());
  glTextureParameteri(texture.get(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(texture.get(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

GlTexture UploadGrime(const cv::Mat& grime) {
  GlTexture texture = MakeTexture(GL_TEXTURE_2D);
  glTextureStorage2D(texture.get(), 1 + static_cast<int>(std::log2(kGrimeSize)), GL_RG8, kGrimeSize,
                     kGrimeSize);
  glTextureSubImage2D(texture.get(), 0, 0, 0, kGrimeSize, kGrimeSize, GL_RG, GL_UNSIGNED_BYTE, grime.data);
  glGenerateTextureMipmap(texture.get());
  // One level is enough for what is this coarse, and half the work.
  glTextureParameteri(texture.get(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTextureParameteri(texture.get(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

GlTexture MakeShadowMap(int size) {
  GlTexture texture = MakeTexture(GL_TEXTURE_2D);
  glTextureStorage2D(texture.get(), 1, GL_DEPTH_COMPONENT16, size, size);
  glTextureParameteri(texture.get(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture.get(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(texture.get(), GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTextureParameteri(texture.get(), GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  glTextureParameteri(texture.get(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  glTextureParameteri(texture.get(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  const std::array<float, 4> lit = {1, 1, 1, 1};
  glTextureParameterfv(texture.get(), GL_TEXTURE_BORDER_COLOR, lit.data());
  return texture;
}

// An orthographic view along the sun's rays that holds a sphere of the town.
glm::mat4 SunView(const glm::vec3& sun, const glm::vec3& middle, float radius) {
  const glm::vec3 up = std::abs(sun.z) > 0.9F ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
  const glm::mat4 view = glm::lookAt(middle + sun * (radius * 2), middle, up);
  return glm::ortho(-radius, radius, -radius, radius, radius * 0.5F, radius * 3.5F) * view;
}

glm::mat4 ToTexture() {
  return glm::translate(glm::mat4(1), glm::vec3(0.5F)) * glm::scale(glm::mat4(1), glm::vec3(0.5F));
}

// Clip coordinates from the camera frame (x right, y down, z forward); row 0 of the image becomes OpenGL's
// lowest row, so that reading back yields the top row first.
glm::mat4 ClipFromCamera(const CameraIntrinsics& camera) {
  const auto w = static_cast<float>(camera.width);
  const auto h = static_cast<float>(camera.height);
  glm::mat4 clip(0.0F);
  clip[0][0] = 2 * static_cast<float>(camera.fx) / w;
  clip[2][0] = (2 * static_cast<float>(camera.cx) + 1 - w) / w;
  clip[1][1] = 2 * static_cast<float>(camera.fy) / h;
  clip[2][1] = (2 * static_cast<float>(camera.cy) + 1 - h) / h;
  clip[2][2] = (kFar + kNear) / (kFar - kNear);
  clip[3][2] = -2 * kFar * kNear / (kFar - kNear);
  clip[2][3] = 1;
  return clip;
}

glm::mat4 ToGlm(const SE3& pose) {
  const Eigen::Matrix4d matrix = pose.Matrix();
  glm::mat4 result;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) result[column][row] = static_cast<float>(matrix(row, column));
  }
  return result;
}

struct Model {
  GpuMesh solid;
  GpuMesh cut;
};

}  // namespace

struct Renderer::State {
  RenderConfig config;
  Weather weather;
  std::unique_ptr<EglContext> context;  // destroyed last
  SurfaceProgram solid[2];              // without and with a look at the shadows
  SurfaceProgram cut[2];
  SurfaceProgram shadow_solid;
  SurfaceProgram shadow_cut;
  SurfaceProgram sky;
  SurfaceProgram sensor;
  GlTexture layers;
  GlTexture grime;
  GlTexture still_shadow;
  GlTexture shadow;  // the still shadows and, drawn over them, those of this frame's moving things
  GlFramebuffer shadow_target;
  GlVertexArray no_vertices;
  Model town_even;   // lit or shaded all over
  Model town_mixed;  // crossed by edges of shadows
  Model dome;
  std::vector<Model> models;
  std::unique_ptr<FrameTarget> target;
  glm::mat4 sun_view{1.0F};
  float texels_per_metre = 1;
  std::vector<cv::Rect> overdrawn;  // places of `shadow` that differ from `still_shadow`
  cv::Mat colour_class;
  std::vector<glm::vec3> casters;  // of moving shadows in this frame

  std::vector<const SurfaceProgram*> AllSurfacePrograms() const;
  absl::Status LoadPrograms();
  absl::Status Upload(const World& world);
  void SetWeather();
  void DrawStillShadows(const World& world);
  void UploadTown(const World& world);
  bool HasSun() const { return weather.sun_light.x > 0.01F; }
  void DrawMovingShadows(const glm::vec3& eye, const std::vector<Instance>& instances);
  cv::Rect TexelsAround(const glm::vec3& caster) const;
  void CopyShadow(const cv::Rect& place) const;
  bool MayBeShadowed(const glm::vec3& low, const glm::vec3& high) const;
  void Use(const SurfaceProgram& program, const glm::mat4& clip_from_town) const;
  void DrawScene(const glm::mat4& town_from_camera, const std::vector<Instance>& instances);
  void DrawInstances(const glm::mat4& clip_from_town, const glm::vec3& eye,
                     const std::vector<Instance>& instances) const;
  void DrawSky(const glm::mat4& clip_from_town, const glm::vec3& eye);
  void DrawSensor(uint32_t frame);
};

std::vector<const SurfaceProgram*> Renderer::State::AllSurfacePrograms() const {
  std::vector<const SurfaceProgram*> programs;
  for (const int i : {0, 1}) {
    programs.push_back(&solid[i]);
    programs.push_back(&cut[i]);
  }
  return programs;
}

absl::Status Renderer::State::LoadPrograms() {
  for (const bool look : {false, true}) {
    SEMMAP_RETURN_IF_ERROR(
        Load(shaders::SurfaceVertex(look), shaders::SurfaceFragment(false, look), &solid[look]));
    SEMMAP_RETURN_IF_ERROR(
        Load(shaders::SurfaceVertex(look), shaders::SurfaceFragment(true, look), &cut[look]));
  }
  SEMMAP_RETURN_IF_ERROR(Load(shaders::ShadowVertex(), shaders::ShadowFragment(false), &shadow_solid));
  SEMMAP_RETURN_IF_ERROR(Load(shaders::ShadowVertex(), shaders::ShadowFragment(true), &shadow_cut));
  SEMMAP_RETURN_IF_ERROR(Load(shaders::SkyVertex(), shaders::SkyFragment(), &sky));
  return Load(shaders::SensorVertex(), shaders::SensorFragment(), &sensor);
}

absl::Status Renderer::State::Upload(const World& world) {
  SEMMAP_ASSIGN_OR_RETURN(FrameTarget made, FrameTarget::Create(config.camera.width, config.camera.height));
  target = std::make_unique<FrameTarget>(std::move(made));
  layers = UploadLayers(PaintAllTextures(world.seed()));
  grime = UploadGrime(PaintGrime(world.seed()));
  MeshBuilder sky_mesh;
  BuildSkyDome(&sky_mesh);
  dome.solid = GpuMesh(sky_mesh.solid(), 0);
  still_shadow = MakeShadowMap(config.shadow_size);
  shadow = MakeShadowMap(config.shadow_size);
  shadow_target = MakeFramebuffer();
  no_vertices = MakeVertexArray();
  return absl::OkStatus();
}

void Renderer::State::SetWeather() {
  const glm::vec3 sun = glm::normalize(weather.sun);
  for (const SurfaceProgram* program : AllSurfacePrograms()) {
    program->Set("u_sun", sun);
    program->Set("u_sun_light", weather.sun_light);
    program->Set("u_sky_light", weather.sky_light);
    program->Set("u_ground_light", weather.ground_light);
    program->Set("u_lamps", weather.lamps);
    program->Set("u_grime_scale", 1.0F / kGrimeMetres);
    program->Set("u_fog", weather.fog);
    program->Set("u_fog_density", weather.fog_density);
  }
  sky.Set("u_sky_tint", weather.sky_tint);
  sky.Set("u_clouds", weather.clouds);
  sky.Set("u_fog", weather.fog);
  sensor.Set("u_near_far", glm::vec2(kNear, kFar));
  sensor.Set("u_exposure", weather.exposure);
  sensor.Set("u_noise", weather.noise);
  sensor.Set("u_vignetting", config.vignetting);
  sensor.Set("u_size", glm::vec2(config.camera.width, config.camera.height));
}

// Draws the map of the still shadows from the whole town.
void Renderer::State::DrawStillShadows(const World& world) {
  const glm::dvec2 low = world.network().Min();
  const glm::dvec2 high = world.network().Max();
  const glm::vec3 middle(glm::vec2((low + high) * 0.5), 0);
  const auto radius = static_cast<float>(glm::distance(low, high) / 2 + 35);
  const glm::mat4 view = SunView(glm::normalize(weather.sun), middle, radius);
  sun_view = view;
  texels_per_metre = static_cast<float>(config.shadow_size) / (2 * radius);
  glNamedFramebufferTexture(shadow_target.get(), GL_DEPTH_ATTACHMENT, still_shadow.get(), 0);
  glBindFramebuffer(GL_FRAMEBUFFER, shadow_target.get());
  glViewport(0, 0, config.shadow_size, config.shadow_size);
  glClear(GL_DEPTH_BUFFER_BIT);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.5F, 2.0F);
  glDisable(GL_CULL_FACE);
  for (const SurfaceProgram* program : {&shadow_solid, &shadow_cut}) {
    program->Set("u_clip_from_town", view);
    program->Set("u_town_from_model", glm::mat4(1));
    glUseProgram(program->program.get());
    GpuMesh(program == &shadow_solid ? world.mesh().solid() : world.mesh().cut(), 0).DrawAll();
  }
  glDisable(GL_POLYGON_OFFSET_FILL);
}

// Uploads the town, parted into what the sun lights evenly and what an edge of a shadow crosses.
void Renderer::State::UploadTown(const World& world) {
  ShadowMap map;
  map.size = config.shadow_size;
  map.depth.resize(static_cast<size_t>(map.size) * static_cast<size_t>(map.size));
  map.texture_from_town = ToTexture() * sun_view;
  glGetTextureImage(still_shadow.get(), 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_SHORT,
                    static_cast<GLsizei>(map.depth.size() * sizeof(uint16_t)), map.depth.data());
  Mesh solid_mesh = world.mesh().solid();
  Mesh cut_mesh = world.mesh().cut();
  for (Mesh* mesh : {&solid_mesh, &cut_mesh}) {
    ClassifySun(map, glm::normalize(weather.sun), mesh);
    // Without a sun there are no edges.
    if (!HasSun()) {
      for (Vertex& vertex : mesh->vertices) vertex.sun = static_cast<uint8_t>(SunState::kDark);
    }
  }
  const auto even = [](const Vertex& vertex) { return vertex.sun != static_cast<uint8_t>(SunState::kMixed); };
  const auto mixed = [](const Vertex& vertex) {
    return vertex.sun == static_cast<uint8_t>(SunState::kMixed);
  };
  town_even = {GpuMesh(solid_mesh, kChunk, even), GpuMesh(cut_mesh, kChunk, even)};
  town_mixed = {GpuMesh(solid_mesh, kChunk, mixed), GpuMesh(cut_mesh, kChunk, mixed)};
}

// Texels of the shadow map around a caster.
cv::Rect Renderer::State::TexelsAround(const glm::vec3& caster) const {
  const glm::vec3 at(ToTexture() * sun_view * glm::vec4(caster, 1));
  const auto size = static_cast<float>(config.shadow_size);
  const int reach = static_cast<int>(kCasterReach * texels_per_metre) + 2;
  const cv::Rect around(static_cast<int>(at.x * size) - reach, static_cast<int>(at.y * size) - reach,
                        2 * reach, 2 * reach);
  return around & cv::Rect(0, 0, config.shadow_size, config.shadow_size);
}

void Renderer::State::CopyShadow(const cv::Rect& place) const {
  glCopyImageSubData(still_shadow.get(), GL_TEXTURE_2D, 0, place.x, place.y, 0, shadow.get(), GL_TEXTURE_2D,
                     0, place.x, place.y, 0, place.width, place.height, 1);
}

void Renderer::State::DrawMovingShadows(const glm::vec3& eye, const std::vector<Instance>& instances) {
  for (const cv::Rect& place : overdrawn) CopyShadow(place);
  overdrawn.clear();
  casters.clear();
  if (!HasSun()) return;
  glNamedFramebufferTexture(shadow_target.get(), GL_DEPTH_ATTACHMENT, shadow.get(), 0);
  glBindFramebuffer(GL_FRAMEBUFFER, shadow_target.get());
  glViewport(0, 0, config.shadow_size, config.shadow_size);
  glDisable(GL_CULL_FACE);
  glUseProgram(shadow_solid.program.get());
  shadow_solid.Set("u_clip_from_town", sun_view);
  for (const Instance& instance : instances) {
    const glm::vec3 at(instance.town_from_model[3]);
    if (!instance.shadow || glm::distance(at, eye) > kMovingShadowReach) continue;
    const cv::Rect place = TexelsAround(at);
    if (place.empty()) continue;
    shadow_solid.Set("u_town_from_model", instance.town_from_model);
    models[static_cast<size_t>(instance.model)].solid.DrawAll();
    overdrawn.push_back(place);
    casters.push_back(at);
  }
}

bool Renderer::State::MayBeShadowed(const glm::vec3& low, const glm::vec3& high) const {
  const glm::vec3 sun = glm::normalize(weather.sun);
  // Where the shadow of the caster's top may end.
  const glm::vec3 throw_length = -glm::vec3(sun.x, sun.y, 0) * (kTallestCaster / std::max(sun.z, 0.1F));
  return std::any_of(casters.begin(), casters.end(), [&](const glm::vec3& caster) {
    const glm::vec3 from = glm::min(caster, caster + throw_length) - kCasterReach;
    const glm::vec3 to = glm::max(caster, caster + throw_length) + kCasterReach;
    return from.x < high.x && to.x > low.x && from.y < high.y && to.y > low.y && low.z < kTallestCaster;
  });
}

void Renderer::State::Use(const SurfaceProgram& program, const glm::mat4& clip_from_town) const {
  program.Set("u_clip_from_town", clip_from_town);
  program.Set("u_town_from_model", glm::mat4(1));
  program.Set("u_shadow_from_town", ToTexture() * sun_view);
  glUseProgram(program.program.get());
}

void Renderer::State::DrawScene(const glm::mat4& town_from_camera, const std::vector<Instance>& instances) {
  const glm::mat4 clip_from_town = ClipFromCamera(config.camera) * glm::inverse(town_from_camera);
  const glm::vec3 eye(town_from_camera[3]);
  const auto shadowed = [this](const glm::vec3& low, const glm::vec3& high) {
    return MayBeShadowed(low, high);
  };
  const auto unshadowed = [this](const glm::vec3& low, const glm::vec3& high) {
    return !MayBeShadowed(low, high);
  };
  const auto draw_town = [&](const SurfaceProgram* programs, GpuMesh Model::*part) {
    Use(programs[1], clip_from_town);
    (town_even.*part).DrawVisible(clip_from_town, eye, shadowed);
    (town_mixed.*part).DrawVisible(clip_from_town, eye);
    Use(programs[0], clip_from_town);
    (town_even.*part).DrawVisible(clip_from_town, eye, unshadowed);
  };
  glEnable(GL_CULL_FACE);
  DrawInstances(clip_from_town, eye, instances);
  draw_town(solid, &Model::solid);
  DrawSky(clip_from_town, eye);
  glDisable(GL_CULL_FACE);
  draw_town(cut, &Model::cut);
}

void Renderer::State::DrawInstances(const glm::mat4& clip_from_town, const glm::vec3& eye,
                                    const std::vector<Instance>& instances) const {
  const SurfaceProgram& program = solid[HasSun() ? 1 : 0];
  Use(program, clip_from_town);
  for (const Instance& instance : instances) {
    program.Set("u_town_from_model", instance.town_from_model);
    models[static_cast<size_t>(instance.model)].solid.DrawVisible(clip_from_town * instance.town_from_model,
                                                                  eye);
  }
}

void Renderer::State::DrawSky(const glm::mat4& clip_from_town, const glm::vec3& eye) {
  glDisable(GL_CULL_FACE);
  glDepthFunc(GL_LEQUAL);
  sky.Set("u_clip_from_town", clip_from_town);
  sky.Set("u_eye", eye);
  glUseProgram(sky.program.get());
  dome.solid.DrawAll();
  glDepthFunc(GL_LESS);
}

void Renderer::State::DrawSensor(uint32_t frame) {
  target->BeginSensor();
  glDisable(GL_DEPTH_TEST);
  sensor.Set("u_frame", frame);
  glUseProgram(sensor.program.get());
  glBindVertexArray(no_vertices.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
}

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Renderer::~Renderer() {
  if (state_ != nullptr) state_->context->MakeCurrent().IgnoreError();
}

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Create(const World& world, const RenderConfig& config,
                                                           const Weather& weather) {
  auto state = std::make_unique<State>();
  state->config = config;
  state->weather = weather;
  SEMMAP_ASSIGN_OR_RETURN(state->context, EglContext::Create());
  SEMMAP_RETURN_IF_ERROR(state->LoadPrograms());
  SEMMAP_RETURN_IF_ERROR(state->Upload(world));
  state->SetWeather();
  glEnable(GL_DEPTH_TEST);
  glFrontFace(GL_CW);  // the image is drawn upside down
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glBindTextureUnit(0, state->layers.get());
  glBindTextureUnit(1, state->grime.get());
  glBindTextureUnit(2, state->shadow.get());
  state->DrawStillShadows(world);
  state->UploadTown(world);
  state->CopyShadow({0, 0, config.shadow_size, config.shadow_size});
  return std::unique_ptr<Renderer>(new Renderer(std::move(state)));
}

int Renderer::AddModel(const MeshBuilder& mesh) {
  state_->context->MakeCurrent().IgnoreError();
  state_->models.push_back({GpuMesh(mesh.solid(), 0), GpuMesh(mesh.cut(), 0)});
  return static_cast<int>(state_->models.size()) - 1;
}

absl::Status Renderer::Render(const SE3& town_from_camera, const std::vector<Instance>& instances,
                              uint32_t frame, View* view) {
  SEMMAP_RETURN_IF_ERROR(state_->context->MakeCurrent());
  const glm::mat4 pose = ToGlm(town_from_camera);
  state_->DrawMovingShadows(glm::vec3(pose[3]), instances);
  state_->target->BeginScene();
  state_->DrawScene(pose, instances);
  state_->DrawSensor(frame);
  state_->target->Read(&state_->colour_class, &view->depth);
  view->rgb.create(state_->colour_class.size(), CV_8UC3);
  view->mask.create(state_->colour_class.size(), CV_8UC1);
  const int from_to[] = {0, 0, 1, 1, 2, 2, 3, 3};
  cv::Mat outputs[] = {view->rgb, view->mask};
  cv::mixChannels(&state_->colour_class, 1, outputs, 2, from_to, 4);
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return absl::InternalError("OpenGL error " + std::to_string(error));
  }
  return absl::OkStatus();
}

const std::string& Renderer::device() const { return state_->context->renderer_name(); }

}  // namespace semmap::town
