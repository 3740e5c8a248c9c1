// Recordings for other programs: CSV tables, ParaView, OVITO.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/evaluation/stop.hpp"
#include "core/recording/sink.hpp"

namespace somas::report {

enum class ExportFormat { csv, vtp, xyz };

/// Writes what a recording's file holds into the directory `out`, which must be absent or empty; it
/// appears under its name when it is complete. docs/recording.md tells the files. Returns the
/// number of frames; nothing if stopped. Throws run::UsageError for a file that is no recording,
/// run::WriteError.
std::optional<std::uint64_t> export_recording(const std::filesystem::path& file,
                                              ExportFormat format, const std::filesystem::path& out,
                                              evaluation::StopToken stop = {});

/// The sinks behind it: they write into a directory that exists. They throw run::WriteError.
[[nodiscard]] std::unique_ptr<recording::Sink> csv_export(const std::filesystem::path& directory);
[[nodiscard]] std::unique_ptr<recording::Sink> vtk_export(const std::filesystem::path& directory);
[[nodiscard]] std::unique_ptr<recording::Sink> xyz_export(const std::filesystem::path& directory);

}  // namespace somas::report
