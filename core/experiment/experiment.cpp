#include "core/experiment/experiment.hpp"

#include "core/experiment/loader.hpp"

namespace somas::experiment {

std::string Position::text() const {
  if (line == 0) return origin;
  return origin + ":" + std::to_string(line) + ":" + std::to_string(column);
}

InputError::InputError(Position position, const std::string& message)
    : std::runtime_error(position.text() + ": " + message), position_(std::move(position)) {}

Experiment load(const std::filesystem::path& file, const LoadOptions& options) {
  return Loader(file, options).load();
}

}  // namespace somas::experiment
