#pragma once

#include <string>

namespace semmap {

// Ten times the colour as scores, at half the size: three channels, red, green and blue.
inline constexpr const char* kColourNetwork = R"(
def forward(self, x):
    return 10.0 * torch.avg_pool2d(x, [2, 2])
)";

// Writes folder/NAME.pt, a TorchScript module without weights whose method has this source, and
// folder/NAME.yaml, which describes it: input 128 x 96, no normalization, `classes` ("carla23" or
// "[7, 9, 13]"). Returns the path of the YAML file.
std::string WriteTinyNetwork(const std::string& folder, const std::string& name, const std::string& source,
                             const std::string& classes);

}  // namespace semmap
