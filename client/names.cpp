#include "client/names.h"

namespace semmap::client {
namespace {

std::string WithPrefix(std::string_view prefix, std::string_view id) {
  if (id.starts_with(prefix)) return std::string(id);
  return std::string(prefix).append(id);
}

}  // namespace

std::string MapName(std::string_view id) { return WithPrefix("maps/", id); }

std::string SessionName(std::string_view id) { return WithPrefix("sessions/", id); }

std::string IdOfName(std::string_view name) {
  const size_t slash = name.rfind('/');
  return std::string(slash == std::string_view::npos ? name : name.substr(slash + 1));
}

}  // namespace semmap::client
