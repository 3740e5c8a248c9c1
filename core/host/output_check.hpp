// Outputs that commands write where the user says.
#pragma once

#include <filesystem>

namespace somas::host {

/// A record that is overwritten proves nothing any more: throws run::UsageError for a file that
/// belongs to the run.
void refuse_file_of_run(const char* option, const std::filesystem::path& file,
                        const std::filesystem::path& run);

}  // namespace somas::host
