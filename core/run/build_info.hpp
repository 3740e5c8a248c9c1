// What this binary was built from and with, for manifests and --version.
#pragma once

#include <string_view>

namespace somas::run {

struct BuildInfo {
  std::string_view version;
  std::string_view compiler;
  std::string_view build_type;
  std::string_view flags;
  std::string_view architecture;  ///< -march; empty: the compiler's baseline
  std::string_view sanitizers;    ///< -fsanitize; empty: none
};

[[nodiscard]] const BuildInfo& build_info();

}  // namespace somas::run
