#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "absl/status/statusor.h"

namespace semmap::town {

// The light of a scene. Colours are linear.
struct Weather {
  std::string name = "noon";
  glm::vec3 sun{0.45F, -0.35F, 0.82F};  // towards the sun, any length
  glm::vec3 sun_light{2.1F, 1.95F, 1.7F};
  glm::vec3 sky_light{0.62F, 0.7F, 0.82F};
  glm::vec3 ground_light{0.3F, 0.28F, 0.25F};
  glm::vec3 sky_tint{1.0F, 1.0F, 1.0F};
  glm::vec3 fog{0.66F, 0.72F, 0.8F};
  float clouds = 0.0F;          // 0 to 1
  float fog_density = 0.0016F;  // per metre
  float lamps = 0.0F;           // brightness of the town's own lights
  float exposure = 1.0F;
  float noise = 0.006F;
};

// `noon`, `morning`, `dusk`, `overcast` or `fog`; INVALID_ARGUMENT otherwise.
absl::StatusOr<Weather> MakeWeather(const std::string& name);
const std::vector<std::string>& WeatherNames();

}  // namespace semmap::town
