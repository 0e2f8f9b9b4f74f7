#pragma once

#include <string>

// GLSL 4.50 sources. All surfaces share one vertex shader.
namespace semmap::town::shaders {

std::string SurfaceVertex();
// `cut_out`: with holes where the texture's alpha is low.
std::string SurfaceFragment(bool cut_out);
std::string ShadowVertex();
std::string ShadowFragment(bool cut_out);
std::string SkyVertex();
std::string SkyFragment();
std::string SensorVertex();
// Joins the samples of each pixel and adds what the camera adds. `samples`: of the multisample targets.
std::string SensorFragment(int samples);

}  // namespace semmap::town::shaders
