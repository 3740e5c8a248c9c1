#include "core/run/state_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <span>
#include <system_error>
#include <xxhash.h>

#include "core/run/files.hpp"
#include "core/run/json.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view state_format = "somas-state/1";
constexpr std::size_t longest_header = 1u << 16;
constexpr std::uint64_t largest_file = std::uint64_t{1} << 30;

std::string file_name(std::uint64_t generation, std::uint32_t population, std::uint64_t step) {
  char name[80];
  std::snprintf(name, sizeof name, "gen-%04llu%s-step-%06llu.state",
                static_cast<unsigned long long>(generation), population > 1 ? "-2" : "",
                static_cast<unsigned long long>(step));
  return name;
}

/// The step in a name of a generation's state; nothing for other names.
std::optional<std::uint64_t> step_in(const std::string& name, std::uint64_t generation,
                                     std::uint32_t population) {
  const std::size_t at = name.rfind('-');
  std::uint64_t step = 0;
  if (at == std::string::npos) return std::nullopt;
  std::from_chars(name.data() + at + 1, name.data() + name.size(), step);
  if (name != file_name(generation, population, step)) return std::nullopt;
  return step;
}

std::string fingerprint(const model::Genome& genome) {
  // The length of the first part tells where the second begins.
  std::vector<std::uint8_t> bytes(genome.controller.begin(), genome.controller.end());
  bytes.insert(bytes.end(), genome.tree.begin(), genome.tree.end());
  const XXH128_hash_t hash =
      XXH3_128bits_withSeed(bytes.data(), bytes.size(), genome.controller.size());
  return hex64(hash.high64) + hex64(hash.low64);
}

}  // namespace

fs::path state_path(const fs::path& run, std::uint64_t generation, std::uint32_t population,
                    std::uint64_t step) {
  return run / "states" / file_name(generation, population, step);
}

std::optional<fs::path> latest_state(const fs::path& run, std::uint64_t generation,
                                     std::uint32_t population, std::uint64_t step) {
  std::optional<std::uint64_t> latest;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(run / "states", error)) {
    const auto found = step_in(entry.path().filename().string(), generation, population);
    if (found && *found <= step) latest = std::max(*found, latest.value_or(0));
  }
  if (!latest) return std::nullopt;
  return state_path(run, generation, population, *latest);
}

SavedState state_of(const Champion& champion, std::uint64_t step, std::uint64_t world_hash,
                    std::vector<std::byte> world) {
  return {.experiment = champion.experiment,
          .generation = champion.generation,
          .individual = champion.individual.id,
          .seed = champion.seed,
          .genome = fingerprint(champion.individual.genome),
          .step = step,
          .world_hash = world_hash,
          .world = std::move(world)};
}

std::string to_text(const SavedState& state) {
  Json json;
  json["format"] = state_format;
  json["experiment"] = state.experiment;
  json["generation"] = state.generation;
  json["id"] = state.individual;
  json["seed"] = hex64(state.seed);
  json["genome_xxh3_128"] = state.genome;
  json["step"] = state.step;
  json["world_hash"] = hex64(state.world_hash);
  std::string text = json.dump() + "\n";
  text.reserve(text.size() + state.world.size());
  for (const std::byte b : state.world) text.push_back(static_cast<char>(b));
  return text;
}

SavedState read_state(const fs::path& file) {
  const std::string text = read_regular_file(file, largest_file);
  const std::string origin = file.string();
  const std::size_t end = std::string_view(text).substr(0, longest_header).find('\n');
  if (end == std::string::npos || !text.starts_with('{'))
    throw UsageError(origin + ": this is no state file: it does not begin with a line of JSON");
  const Json json = parse_json(std::string_view(text).substr(0, end), origin);
  const JsonView view(json, origin);
  if (view.member("format").text() != state_format)
    view.member("format").fail("\"" + std::string(state_format) + "\"");
  SavedState state{.experiment = std::string(view.member("experiment").text()),
                   .generation = view.member("generation").natural(),
                   .individual = view.member("id").natural(),
                   .seed = view.member("seed").key64(),
                   .genome = std::string(view.member("genome_xxh3_128").text()),
                   .step = view.member("step").natural(),
                   .world_hash = view.member("world_hash").key64(),
                   .world = {}};
  const auto bytes = std::as_bytes(std::span(text).subspan(end + 1));
  state.world.assign(bytes.begin(), bytes.end());
  return state;
}

void check_owner(const SavedState& state, const Champion& champion, const std::string& origin) {
  const auto require = [&](const std::string& what, const std::string& there,
                           const std::string& here) {
    if (there != here)
      throw UsageError(origin + ": the state is of another life: " + what + " " + there + ", not " +
                       here);
  };
  require("experiment", state.experiment, champion.experiment);
  require("generation", std::to_string(state.generation), std::to_string(champion.generation));
  require("individual", std::to_string(state.individual), std::to_string(champion.individual.id));
  require("seed", hex64(state.seed), hex64(champion.seed));
  require("genome", state.genome, fingerprint(champion.individual.genome));
  const std::vector<std::uint64_t>& hashes = champion.life.hashes;
  if (state.step == 0 || state.step >= hashes.size())
    throw UsageError(origin + ": the state comes before step " + std::to_string(state.step) +
                     "; the recorded life has such moments before steps 1 to " +
                     std::to_string(hashes.empty() ? 0 : hashes.size() - 1));
  require("world before step " + std::to_string(state.step), hex64(state.world_hash),
          hex64(hashes[state.step - 1]));
}

}  // namespace somas::run
