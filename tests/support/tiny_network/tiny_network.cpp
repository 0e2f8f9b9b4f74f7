#include "tests/support/tiny_network/tiny_network.h"

#include <fstream>

#include <torch/csrc/jit/api/module.h>

namespace semmap {

std::string WriteTinyNetwork(const std::string& folder, const std::string& name, const std::string& source,
                             const std::string& classes) {
  torch::jit::Module module("tiny");
  module.define(source);
  module.save(folder + "/" + name + ".pt");
  std::string path = folder + "/" + name + ".yaml";
  std::ofstream(path) << "file: " << name << ".pt\ninput_width: 128\ninput_height: 96\nclasses: " << classes
                      << "\n";
  return path;
}

}  // namespace semmap
