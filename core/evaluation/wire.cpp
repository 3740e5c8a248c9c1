#include "core/evaluation/wire.hpp"

#include <algorithm>

namespace somas::evaluation {
namespace {

// Nothing that is sent comes near it; a damaged length must not make us wait for ever.
constexpr std::uint64_t largest_message = std::uint64_t{1} << 30;

model::Genome decode_genome(Reader& in) {
  model::Genome genome;
  for (auto* genes : {&genome.controller, &genome.tree}) {
    const std::string_view bytes = in.text();
    genes->assign(bytes.begin(), bytes.end());
  }
  return genome;
}

std::string_view bytes_of(const Genes& genes) {
  return {reinterpret_cast<const char*>(genes.data()), genes.size()};
}

}  // namespace

ExperimentMessage message_of(const experiment::Experiment& experiment, std::uint32_t id) {
  ExperimentMessage message{
      .id = id, .canary = 0, .yaml = experiment.resolved_yaml, .plugin_path = {}};
  for (const experiment::Experiment::Library& library : experiment.libraries) {
    std::string directory = std::filesystem::absolute(library.file).parent_path().string();
    auto& path = message.plugin_path;
    if (std::find(path.begin(), path.end(), directory) == path.end())
      path.push_back(std::move(directory));
  }
  return message;
}

std::string encode(const ExperimentMessage& message) {
  Writer out;
  out.put(Tag::experiment).put(message.id).put(message.canary).text(message.yaml);
  for (const std::string& directory : message.plugin_path) out.text(directory);
  return out.take();
}

ExperimentMessage decode_experiment(Reader in) {
  ExperimentMessage message;
  message.id = in.get<std::uint32_t>();
  message.canary = in.get<std::uint32_t>();
  message.yaml = in.text();
  while (!in.done()) message.plugin_path.emplace_back(in.text());
  return message;
}

std::string encode(const ReadyMessage& message) {
  Writer out;
  out.put(Tag::ready).put(message.id).put(message.canary);
  out.text(message.hash).text(message.machine);
  return out.take();
}

ReadyMessage decode_ready(Reader in) {
  ReadyMessage message;
  message.id = in.get<std::uint32_t>();
  message.canary = in.get<std::uint32_t>();
  message.hash = in.text();
  message.machine = in.text();
  return message;
}

void encode(Writer& out, const Task& task) {
  out.put(task.seed).put(static_cast<std::uint32_t>(task.roster.size()));
  for (const Organism& organism : task.roster) {
    out.put(organism.key).put(organism.x).put(organism.y);
    out.text(bytes_of(organism.genome->controller)).text(bytes_of(organism.genome->tree));
  }
}

OwnedTask decode_task(Reader& in) {
  OwnedTask owned;
  owned.task.seed = in.get<std::uint64_t>();
  const auto count = in.get<std::uint32_t>();
  if (count > in.rest().size()) throw WireError();
  owned.genomes.resize(count);
  for (model::Genome& genome : owned.genomes) {
    Organism organism{.genome = &genome};
    organism.key = in.get<std::uint64_t>();
    organism.x = in.get<double>();
    organism.y = in.get<double>();
    genome = decode_genome(in);
    owned.task.roster.push_back(organism);
  }
  return owned;
}

void encode(Writer& out, const Result& result) {
  static_assert(std::is_trivially_copyable_v<Row>);
  out.put(static_cast<std::uint32_t>(result.rows.size()));
  for (const Row& row : result.rows) out.put(row);
  out.put(result.failure.has_value());
  if (!result.failure) return;
  const Failure& failure = *result.failure;
  out.put(failure.attempts).text(failure.cause).text(failure.plugin);
  out.put(failure.step.has_value()).put(failure.step.value_or(0));
}

Result decode_result(Reader& in) {
  Result result;
  const auto count = in.get<std::uint32_t>();
  if (count > in.rest().size()) throw WireError();
  for (std::uint32_t i = 0; i < count; ++i) result.rows.push_back(in.get<Row>());
  if (!in.get<bool>()) return result;
  Failure& failure = result.failure.emplace();
  failure.attempts = in.get<std::uint32_t>();
  failure.cause = in.text();
  failure.plugin = in.text();
  const bool known = in.get<bool>();
  const auto step = in.get<std::uint64_t>();
  if (known) failure.step = step;
  return result;
}

std::string framed(std::string_view message) {
  Writer out;
  out.text(message);
  return out.take();
}

bool take_frame(std::string& arrived, std::string& message) {
  std::uint64_t size = 0;
  if (arrived.size() < sizeof size) return false;
  std::memcpy(&size, arrived.data(), sizeof size);
  if (size > largest_message) throw WireError();
  if (arrived.size() - sizeof size < size) return false;
  message.assign(arrived, sizeof size, size);
  arrived.erase(0, sizeof size + size);
  return true;
}

}  // namespace somas::evaluation
