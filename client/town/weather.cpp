#include "client/town/weather.h"

#include "absl/strings/str_cat.h"

namespace semmap::town {
namespace {

std::vector<Weather> MakeAll() {
  Weather noon;
  Weather morning = noon;
  morning.name = "morning";
  morning.sun = {0.75F, 0.45F, 0.42F};
  morning.sun_light = {2.2F, 1.75F, 1.25F};
  morning.sky_light = {0.5F, 0.58F, 0.72F};
  morning.fog = {0.75F, 0.72F, 0.68F};
  Weather dusk = noon;
  dusk.name = "dusk";
  dusk.sun = {-0.86F, 0.2F, 0.2F};
  dusk.sun_light = {0.75F, 0.38F, 0.16F};
  dusk.sky_light = {0.2F, 0.22F, 0.34F};
  dusk.ground_light = {0.12F, 0.1F, 0.11F};
  dusk.sky_tint = {0.5F, 0.36F, 0.36F};
  dusk.fog = {0.34F, 0.25F, 0.24F};
  dusk.lamps = 0.9F;
  dusk.exposure = 1.9F;
  dusk.noise = 0.012F;
  Weather overcast = noon;
  overcast.name = "overcast";
  overcast.sun_light = {0.0F, 0.0F, 0.0F};
  overcast.sky_light = {1.0F, 1.03F, 1.07F};
  overcast.ground_light = {0.46F, 0.45F, 0.43F};
  overcast.sky_tint = {0.85F, 0.86F, 0.88F};
  overcast.fog = {0.62F, 0.64F, 0.66F};
  overcast.clouds = 0.85F;
  overcast.exposure = 1.1F;
  Weather fog = overcast;
  fog.name = "fog";
  fog.fog_density = 0.018F;
  return {noon, morning, dusk, overcast, fog};
}

const std::vector<Weather>& All() {
  static const std::vector<Weather> all = MakeAll();
  return all;
}

}  // namespace

const std::vector<std::string>& WeatherNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Weather& weather : All()) list.push_back(weather.name);
    return list;
  }();
  return names;
}

absl::StatusOr<Weather> MakeWeather(const std::string& name) {
  for (const Weather& weather : All()) {
    if (weather.name == name) return weather;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("no weather '", name, "'; there are noon, morning, dusk, overcast and fog"));
}

}  // namespace semmap::town
