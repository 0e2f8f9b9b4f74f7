#pragma once

namespace semmap {
class ConfigReader;
}
