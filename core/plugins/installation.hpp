// Where this host stands, and what comes with it: all found from the executable, so that an
// installation can be moved. A build tree has the same layout.
#pragma once

#include <filesystem>

namespace somas::plugins {

/// The running program; empty where the system does not tell.
[[nodiscard]] std::filesystem::path executable_file();
/// Where it stands; empty as above.
[[nodiscard]] std::filesystem::path executable_directory();

/// What bin/, lib/ and share/ stand in.
[[nodiscard]] std::filesystem::path prefix_directory();

/// share/somas: experiments/ and template/.
[[nodiscard]] std::filesystem::path share_directory();

}  // namespace somas::plugins
