#include "core/experiment/loader.hpp"

#include <algorithm>
#include <new>

#include "core/experiment/overlay.hpp"
#include "core/experiment/reader.hpp"
#include "core/experiment/sweep.hpp"
#include "core/model/call_site.hpp"
#include "core/plugins/suggest.hpp"
#include "core/plugins/yaml_text.hpp"

namespace somas::experiment {
namespace {

constexpr PluginKind single_kinds[] = {PluginKind::specialization, PluginKind::controller,
                                       PluginKind::fitness};

bool directory_exists(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

// Names of environments become columns and parts of key paths.
bool is_name(const std::string& text) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  return !text.empty() && text[0] != '-' && std::all_of(text.begin(), text.end(), allowed);
}

/// The first node below `node` that has the text as its key or value.
const Node* says(const Node& node, const std::string& text) {
  for (const Node& item : node.items) {
    if (item.key == text || (item.kind == Node::Kind::scalar && item.text == text)) return &item;
    if (const Node* found = says(item, text)) return found;
  }
  return nullptr;
}

std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  return text;
}

}  // namespace

std::vector<plugins::SearchDirectory> search_path(
    const std::vector<std::filesystem::path>& plugin_directories) {
  std::vector<plugins::SearchDirectory> path;
  for (const std::filesystem::path& directory : plugin_directories) {
    if (!directory_exists(directory))
      throw InputError({"--plugin-path " + directory.string(), 0, 0}, "no such directory");
    path.push_back({directory, "--plugin-path"});
  }
  for (plugins::SearchDirectory& place : plugins::standard_search_path())
    path.push_back(std::move(place));
  return path;
}

Experiment Loader::load() {
  read();
  check_core();
  find_plugins();
  check_blocks();
  problems_.raise();
  wire();

  Experiment experiment;
  experiment.name = values_.name;
  experiment.seed = static_cast<std::uint64_t>(values_.seed);
  experiment.evolution = values_.evolution;
  experiment.record = values_.record;
  experiment.ecosystem = ecosystem_;
  experiment.specialization = plugin_of("specialization");
  experiment.controller = plugin_of("controller");
  experiment.original_yaml = text_;
  experiment.resolved_yaml = resolved();
  experiment.simulation_yaml = simulation_part();
  experiment.libraries = libraries();
  return experiment;
}

void Loader::read() {
  text_ = read_text(file_);
  root_ = read_tree(file_, text_);

  if (const Node* environments = root_.find("environments")) environments_ = keys_of(*environments);

  // The choice of a plugin replaces its block, so what else is set in it has to come later.
  std::vector<Override> overrides;
  for (const std::string& assignment : options_.overrides)
    overrides.push_back(set_by_hand(assignment));
  overrides.insert(overrides.end(), options_.levels.begin(), options_.levels.end());
  std::stable_partition(overrides.begin(), overrides.end(),
                        [](const Override& given) { return chooses_plugin(given.text); });
  for (const Override& given : overrides) apply_override(root_, given);
}

void Loader::check_core() {
  core_ = validator_.group(core_keys(), root_, "", other_keys());
  check_sweep(root_, problems_);

  // A name that is not given is the file's.
  for (plugins::ParameterValue& field : core_.items)
    if (field.key == "name" && root_.find("name") == nullptr) field.text = file_.stem().string();
  values_ = core_values(core_);
  const Node* name = root_.find("name");
  if (name == nullptr) {
    const std::string fault = fault_in_name(values_.name);
    if (!fault.empty())
      problems_.add({file_.string(), 0, 0}, "name",
                    fault + " (left out, it is the file's without its extension; give one)");
  } else if (name->kind == Node::Kind::scalar) {
    const std::string fault = fault_in_name(name->text);
    if (!fault.empty()) problems_.add(name->position, "name", fault);
  }
  if (const auto fault = evolution::fault_in(values_.evolution)) {
    const std::string path = "evolution." + fault->key;
    problems_.add(nearest(root_, path).position, path, fault->message);
  } else if (values_.evolution.mode != evolution::Mode::solo &&
             values_.evolution.roster.distance > values_.world.radius) {
    problems_.add(nearest(root_, "evolution.roster.distance").position, "evolution.roster.distance",
                  plugins::format_number(values_.evolution.roster.distance) +
                      " is outside the world; allowed: at most world.radius, " +
                      plugins::format_number(values_.world.radius));
  }
  if (values_.world.morphogens.size % 2 == 0)
    problems_.add(nearest(root_, "world.morphogens.size").position, "world.morphogens.size",
                  std::to_string(values_.world.morphogens.size) +
                      " is even; allowed: odd numbers, so that one square is at the centre");
}

void Loader::find_plugins() {
  std::vector<plugins::SearchDirectory> path;
  const Node* given = root_.find("plugins");
  if (given != nullptr && given->kind != Node::Kind::sequence)
    problems_.add(given->position, "plugins",
                  "expected a list of directories, found " + given->description());
  if (given != nullptr && given->kind == Node::Kind::sequence) {
    for (std::size_t i = 0; i < given->items.size(); ++i) {
      const Node& item = given->items[i];
      const std::string key = indexed("plugins", i);
      const std::optional<std::string> text = validator_.text(item, key);
      if (!text) continue;

      // Relative to the file that says it; an override is relative to where we are.
      const bool in_file = item.position.line != 0;
      const std::filesystem::path base =
          in_file ? std::filesystem::path(item.position.origin).parent_path() : "";
      std::filesystem::path directory = std::filesystem::absolute(base / *text).lexically_normal();
      if (directory_exists(directory)) {
        path.push_back({directory, item.position.text()});
        directories_.push_back(std::move(directory));
      } else {
        problems_.add(item.position, key, "no such directory: " + directory.string());
      }
    }
  }
  for (plugins::SearchDirectory& place : search_path(options_.plugin_directories))
    path.push_back(std::move(place));
  if (options_.linked_in != nullptr)
    registry_.emplace(plugins::Registry::of(options_.linked_in));
  else
    registry_.emplace(std::move(path));
}

void Loader::check_blocks() {
  check_environments();
  for (const PluginKind kind : single_kinds) check_single(kind);
}

void Loader::check_environments() {
  const Node* environments = root_.find("environments");
  if (environments == nullptr || !validator_.expect_mapping(*environments, "environments")) return;
  for (const Node& node : environments->items) {
    const std::string path = "environments." + node.key;
    const bool reserved =
        std::any_of(std::begin(single_kinds), std::end(single_kinds),
                    [&](PluginKind kind) { return plugins::kind_name(kind) == node.key; });
    if (!is_name(node.key) || reserved) {
      problems_.add(node.key_position, path,
                    reserved ? "this name is taken by the block '" + node.key + "'"
                             : "a name has letters, digits, '_' and '-' only");
    } else if (node.kind == Node::Kind::null) {
      problems_.add(node.key_position, path,
                    "null removes an inherited environment, but none is inherited; write {} for "
                    "all defaults");
    } else if (only_set(node)) {
      problems_.add(node.key_position, path, no_such_environment(node.key));
    } else {
      check_block(PluginKind::environment, node, path, node.key, node.key);
    }
  }
}

// Made by --set, and nothing says of which plugin: likely a name misspelt.
bool Loader::only_set(const Node& environment) const {
  const auto has = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), environment.key) != names.end();
  };
  const bool says_plugin =
      environment.kind != Node::Kind::mapping || environment.find("plugin") != nullptr;
  return !says_plugin && !has(environments_) && !has(registry_->ids());
}

std::string Loader::no_such_environment(const std::string& name) const {
  // A slip for a name in use is likelier than one for a plugin.
  std::string hint = plugins::did_you_mean(name, environments_);
  if (hint.empty()) hint = plugins::did_you_mean(name, registry_->ids(PluginKind::environment));
  return "there is no such environment; have: " + plugins::join(environments_) + hint +
         " (a new one needs its plugin: --set environments." + name + ".plugin=ID)";
}

void Loader::check_single(PluginKind kind) {
  const std::string name = plugins::kind_name(kind);
  if (const Node* node = root_.find(name)) {
    check_block(kind, *node, name, name, "");
    return;
  }
  problems_.add(root_.key_position, name,
                "missing; write '" + name +
                    ": {plugin: ID}'; available: " + plugins::join(registry_->ids(kind)));
}

void Loader::check_block(PluginKind kind, const Node& node, const std::string& path,
                         const std::string& instance, const std::string& default_plugin) {
  if (node.kind == Node::Kind::null) {
    problems_.add(node.position, path,
                  "expected a mapping with 'plugin: ID', found nothing (null)");
    return;
  }
  if (!validator_.expect_mapping(node, path)) return;
  const Node* plugin = node.find("plugin");
  std::optional<std::string> id = default_plugin;
  if (plugin != nullptr) id = validator_.text(*plugin, path + ".plugin");
  if (!id) return;
  if (plugin == nullptr && id->empty()) {
    problems_.add(node.key_position, path + ".plugin",
                  "missing; available: " + plugins::join(registry_->ids(kind)));
    return;
  }

  // Parameters can be checked only against a plugin that is there.
  const std::vector<std::string> handled = {"plugin"};
  try {
    Block block{path, instance, &node, registry_->find(kind, *id), {}};
    block.parameters = validator_.group(block.plugin.parameters(), node, path, handled);
    blocks_.push_back(std::move(block));
  } catch (const plugins::LookupError& error) {
    problems_.add(plugin != nullptr ? plugin->position : node.key_position,
                  plugin != nullptr ? path + ".plugin" : path, error.what());
  }
}

// ---- wiring ------------------------------------------------------------------------------------

const Loader::Block& Loader::block(const std::string& instance) const {
  for (const Block& block : blocks_)
    if (block.instance == instance) return block;
  throw std::logic_error("no block is called '" + instance + "'");
}

void Loader::blame(const std::string& instance, const std::string& path,
                   const std::string& message) const {
  const Block& blamed = block(instance);
  const Node& place = path.empty() ? *blamed.node : nearest(*blamed.node, path);
  throw InputError(place.key_position,
                   (path.empty() ? blamed.path : joined(blamed.path, path)) + ": " + message);
}

template <class Interface>
std::shared_ptr<Interface> Loader::create(const Block& block) const {
  try {
    const model::PluginCall here(block.instance, "constructor");
    return block.plugin.create<Interface>(block.parameters);
  } catch (const ParameterError& error) {
    blame(block.instance, error.path(), error.what());
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
  } catch (const std::exception& error) {
    blame(block.instance, "",
          "the plugin '" + block.plugin.id() + "' cannot be created: " + error.what());
  } catch (...) {
    blame(block.instance, "",
          "the plugin '" + block.plugin.id() +
              "' cannot be created: it threw something that is no std::exception");
  }
}

void Loader::wire() {
  std::vector<model::NamedEnvironment> environments;
  for (const Block& block : blocks_)
    if (block.plugin.info->kind == PluginKind::environment)
      environments.push_back({block.instance, create<Environment>(block)});
  auto specialization = create<Specialization>(block("specialization"));
  auto controller = create<Controller>(block("controller"));
  auto fitness = create<Fitness>(block("fitness"));

  try {
    ecosystem_ = std::make_shared<const model::Ecosystem>(
        values_.world, std::move(environments), std::move(specialization), std::move(controller),
        std::move(fitness));
  } catch (const model::WiringError& error) {
    blame(error.instance(), error.path(), error.what());
  } catch (const model::PluginFailure& error) {
    blame(error.instance(), "", error.what());
  } catch (const model::UnstableTimeStep& error) {
    const std::string key = "world.mechanics.time_step";
    throw InputError(nearest(root_, key).key_position, key + ": " + error.what());
  }
  check_states();
}

// Names of states become columns and keys. Only the tree's plugin knows where in its block one
// stands: it is looked for.
void Loader::check_states() const {
  if (ecosystem_->fixed_tree() == nullptr) return;
  const Block& tree = block("specialization");
  for (const model::State& state : ecosystem_->fixed_tree()->states) {
    const auto allowed = [](char c) { return c == '.' || is_name(std::string("a") + c); };
    if (std::all_of(state.name.begin(), state.name.end(), allowed)) continue;
    const Node* place = says(*tree.node, state.name);
    const bool is_key = place != nullptr && place->key == state.name;
    const Node& blamed = place != nullptr ? *place : *tree.node;
    throw InputError(is_key ? blamed.key_position : blamed.position,
                     tree.path + ": the state '" + printable(state.name) +
                         "': a name has letters, digits, '_', '-' and '.' only");
  }
}

// ---- what was loaded ---------------------------------------------------------------------------

std::string Loader::resolved() const {
  std::string out = "# Every key with its value.\n";
  for (const char* key : {"somas", "name", "seed"}) plugins::write_field(out, *core_.find(key), 0);
  if (!directories_.empty()) out += "plugins:\n";
  for (const std::filesystem::path& directory : directories_)
    out += "  - " + plugins::yaml_text(directory.string()) + "\n";
  out += simulation_part();
  for (const char* key : {"evolution", "record"}) plugins::write_field(out, *core_.find(key), 0);
  return out;
}

std::string Loader::simulation_part() const {
  std::string out;
  const auto write_block = [&](const Block& block, int indent) {
    const std::string margin(static_cast<std::size_t>(indent), ' ');
    out += margin + block.node->key + ":\n";
    out += margin + "  plugin: " + plugins::yaml_text(block.plugin.id()) + "\n";
    plugins::write_fields(out, block.parameters, indent + 2);
  };

  plugins::write_field(out, *core_.find("world"), 0);
  const bool any = std::any_of(blocks_.begin(), blocks_.end(), [](const Block& block) {
    return block.plugin.info->kind == PluginKind::environment;
  });
  out += any ? "environments:\n" : "environments: {}\n";
  for (const Block& block : blocks_)
    if (block.plugin.info->kind == PluginKind::environment) write_block(block, 2);
  for (const PluginKind kind : single_kinds) write_block(block(plugins::kind_name(kind)), 0);
  return out;
}

PluginUse Loader::plugin_of(const std::string& instance) const {
  const plugins::PluginClass& plugin = block(instance).plugin;
  return {plugin.id(), plugin.library->version()};
}

std::vector<Experiment::Library> Loader::libraries() const {
  std::vector<Experiment::Library> used;
  for (const Block& block : blocks_) {
    const plugins::Library& library = *block.plugin.library;
    auto entry = std::find_if(used.begin(), used.end(), [&](const Experiment::Library& one) {
      return one.file == library.file();
    });
    if (entry == used.end())
      entry = used.insert(
          used.end(), {library.file(), library.id(), library.version(), library.fingerprint(), {}});
    const std::string id = block.plugin.id();
    if (std::find(entry->classes.begin(), entry->classes.end(), id) == entry->classes.end())
      entry->classes.push_back(id);
  }
  return used;
}

}  // namespace somas::experiment
