#pragma once

#include <string>

// GLSL 4.50 sources. All surfaces share one vertex shader.
namespace semmap::town::shaders {

// `shadow`: looks the sun up at each pixel; without, the surface's sun state says all.
std::string SurfaceVertex(bool shadow);
// `cut_out`: with holes where the texture's alpha is low, and without stains.
std::string SurfaceFragment(bool cut_out, bool shadow);
std::string ShadowVertex();
std::string ShadowFragment(bool cut_out);
std::string SkyVertex();
std::string SkyFragment();
std::string SensorVertex();
// Smooths edges and adds what the camera adds.
std::string SensorFragment();

}  // namespace semmap::town::shaders
