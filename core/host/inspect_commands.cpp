// Commands that look and touch nothing: validate, plugins, describe.
#include "core/experiment/experiment.hpp"
#include "core/experiment/warnings.hpp"
#include "core/host/campaign_command.hpp"
#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/plugins/describe.hpp"
#include "core/plugins/suggest.hpp"
#include "core/plugins/values.hpp"
#include "core/run/errors.hpp"

namespace somas::host {
namespace {

using plugins::plural;

std::string summary_of(const experiment::Experiment& experiment) {
  const model::Ecosystem& ecosystem = *experiment.ecosystem;
  const evolution::Settings& settings = experiment.evolution;
  std::string text = "OK: " + experiment.name + ", seed " + std::to_string(experiment.seed) + "\n";
  text += "  evolution: " + plural(settings.generations, "generation") + " of " +
          std::to_string(settings.population) + ", " + plural(settings.trials, "trial") + "\n";
  if (settings.mode != evolution::Mode::solo)
    text += "  mode: " + std::string(evolution::name_of(settings.mode)) + ", " +
            plural(settings.roster.size, "organism") + " a world\n";

  text += "  world: radius " + plugins::format_number(ecosystem.config().radius) + ", at most " +
          plural(ecosystem.config().max_steps, "step") + ", " +
          plural(ecosystem.config().morphogens.kinds.size(), "morphogen") + "\n";
  text += "  environments:";
  for (const model::NamedEnvironment& environment : ecosystem.environments())
    text.append(" ").append(environment.name);
  text += ecosystem.environments().empty() ? " none\n" : "\n";

  text += "  states:";
  if (ecosystem.fixed_tree() == nullptr)
    text += " evolve";
  else
    for (const model::State& state : ecosystem.fixed_tree()->states)
      text.append(" ").append(state.name);
  text += "\n  controller ports:";
  if (ecosystem.fixed_ports() == nullptr) {
    text += " follow the tree\n";
  } else {
    const Layout& layout = ecosystem.fixed_ports()->layout();
    text += " " + plural(layout.input_channels, "input") + " a state, " +
            plural(layout.outputs.size(), "output") + "\n";
  }
  text += "  fitness: " + std::string(ecosystem.fitness().objective()) + "\n";
  for (const experiment::Experiment::Library& library : experiment.libraries)
    text += "  plugin: " + library.plugin_id + " " + library.version + " (" +
            library.file.string() + ")\n";
  for (const std::string& warning : experiment::warnings_of(experiment))
    text += "  warning: " + warning + "\n";
  return text;
}

plugins::Registry registry_with(const std::vector<std::filesystem::path>& given) {
  std::vector<plugins::SearchDirectory> directories;
  directories.reserve(given.size());
  for (const std::filesystem::path& directory : given)
    directories.push_back({directory, "--plugin-path"});
  for (plugins::SearchDirectory& directory : plugins::standard_search_path())
    directories.push_back(std::move(directory));
  return plugins::Registry(std::move(directories));
}

plugins::DescribeFormat format_named(const std::string& name) {
  if (name == "yaml") return plugins::DescribeFormat::yaml;
  return name == "markdown" ? plugins::DescribeFormat::markdown : plugins::DescribeFormat::text;
}

}  // namespace

int execute(const ValidateCommand& command, run::Terminal&) {
  const auto design = experiment::read_design(command.file, {command.overrides, command.sweeps});
  if (design && !design->is_one_run() && !command.show_resolved)
    return validate_design(command, *design);
  const experiment::Experiment experiment =
      experiment::load(command.file, {command.overrides, command.plugin_path});
  print(command.show_resolved ? experiment.resolved_yaml : summary_of(experiment));
  return exit_ok;
}

int execute(const PluginsCommand& command, run::Terminal&) {
  print(plugins::listing(registry_with(command.plugin_path)));
  return exit_ok;
}

int execute(const DescribeCommand& command, run::Terminal&) {
  const plugins::Registry registry = registry_with(command.plugin_path);
  try {
    print(plugins::describe(registry.find(command.id), format_named(command.format)));
  } catch (const plugins::LookupError& error) {
    throw run::UsageError(error.what());
  }
  return exit_ok;
}

}  // namespace somas::host
