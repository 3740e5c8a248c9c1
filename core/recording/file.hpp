// Recordings as HDF5 files. docs/recording.md describes what is in one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/recording/recording.hpp"
#include "core/recording/sink.hpp"

namespace somas::recording {

/// A file that is no recording, or is damaged. The message starts with its path.
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& path, const std::string& what)
      : std::runtime_error(path.string() + ": " + what) {}
};

/// Builds the bytes of a file, in memory and compressed; the same life makes the same bytes. One
/// thread at a time may use writers and readers.
class FileWriter final : public Sink {
 public:
  FileWriter();
  ~FileWriter() override;
  void begin(const Header& header) override;
  void event(const Event& event) override;
  void summary(const Summary& summary) override;
  void frame(const Frame& frame) override;
  void finish(const Ending& ending) override;

  /// After `finish`.
  [[nodiscard]] std::vector<std::byte> bytes() const;

 private:
  struct Sets;
  std::unique_ptr<Sets> sets_;
};

/// The header alone. Throws FileError.
[[nodiscard]] Header read_header(const std::filesystem::path& file);

/// Hands a file on to a sink, frame by frame, as the recorder did. Throws FileError.
void read(const std::filesystem::path& file, Sink& sink);

/// All of it. Throws FileError.
[[nodiscard]] Recording read(const std::filesystem::path& file);

}  // namespace somas::recording
