#include "core/model/ecosystem.hpp"

#include <cmath>
#include <sstream>

#include "core/model/call_site.hpp"

namespace somas::model {

namespace {

/// Calls into a plugin; whatever it throws leaves as an error that names instance and call.
template <class Call>
decltype(auto) guarded(const std::string& instance, const char* call, Call&& body) {
  const PluginCall here(instance, call);
  try {
    return body();
  } catch (const ParameterError& error) {
    throw WiringError(instance, error.path(), error.what());
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
  } catch (const std::exception& error) {
    throw PluginFailure(instance, call, error.what());
  } catch (...) {
    throw PluginFailure(instance, call, "an exception that is no std::exception");
  }
}

bool positive(double x) { return std::isfinite(x) && x > 0; }
bool not_negative(double x) { return std::isfinite(x) && x >= 0; }

/// Copies what a specialization emits, and refuses what no world could hold.
class TreeBuilder final : public TreeSink {
 public:
  TreeBuilder(const std::vector<Skill>& skills, std::size_t morphogens)
      : skills_(skills), morphogens_(static_cast<std::uint32_t>(morphogens)) {}

  [[nodiscard]] std::uint32_t morphogens() const override { return morphogens_; }

  void add(const StateSpec& spec) override {
    check_attributes(spec);
    check_behaviour(spec);
    State state{.name = std::string(spec.name),
                .key = spec.key != 0 ? spec.key : stable_key(spec.name),
                .parent = spec.parent,
                .mass = spec.mass,
                .radius = spec.radius,
                .stiffness = spec.stiffness,
                .adhesion = spec.adhesion,
                .adhesion_range = spec.adhesion_range,
                .motility = spec.motility,
                .motility_signal = spec.motility_signal,
                .thresholds = {.quiescence = static_cast<float>(spec.quiescence_threshold),
                               .division = static_cast<float>(spec.division_threshold),
                               .specialization = static_cast<float>(spec.specialization_threshold),
                               .apoptosis = static_cast<float>(spec.apoptosis_threshold)},
                .skills = {spec.skills.begin(), spec.skills.end()},
                .children = {}};
    for (const State& other : tree_.states)
      require(other.name != state.name && other.key != state.key, spec, "the name or key is taken");
    const auto index = static_cast<std::uint16_t>(tree_.states.size());
    if (index > 0) tree_.states[spec.parent].children.push_back(index);
    adhesion_with_.emplace_back(spec.adhesion_with.begin(), spec.adhesion_with.end());
    tree_.states.push_back(std::move(state));
  }

  Tree take() {
    if (tree_.states.empty()) throw std::runtime_error("the tree has no states");
    resolve_adhesion();
    return std::move(tree_);
  }

 private:
  static void require(bool fine, const StateSpec& spec, const char* what) {
    if (!fine) throw std::runtime_error("state '" + std::string(spec.name) + "': " + what);
  }

  void check_attributes(const StateSpec& spec) const {
    const bool root = tree_.states.empty();
    require(!spec.name.empty(), spec, "a state needs a name");
    require(root == (spec.parent == no_state), spec, "one state, the first, is the root");
    require(root || spec.parent < tree_.states.size(), spec, "its parent must come before it");
    require(positive(spec.mass) && positive(spec.radius), spec, "mass and radius must be positive");
    require(not_negative(spec.stiffness) && not_negative(spec.adhesion), spec,
            "stiffness and adhesion must not be negative");
    require(std::isfinite(spec.adhesion_range) && spec.adhesion_range >= 1, spec,
            "the adhesion range must be at least 1");
    require(spec.adhesion_with.size() <= tree_.states.size(), spec,
            "adhesion_with is for the states before it only");
    for (const double adhesion : spec.adhesion_with)
      require(std::isnan(adhesion) || not_negative(adhesion), spec,
              "an adhesion to another state must be finite and not negative");
    require(spec.skills.size() == skills_.size(), spec, "one value is needed for every skill");
    for (std::size_t i = 0; i < skills_.size(); ++i)
      require(std::isfinite(spec.skills[i]) && spec.skills[i] >= skills_[i].spec.minimum &&
                  spec.skills[i] <= skills_[i].spec.maximum,
              spec, "a skill is out of its range");
  }

  void check_behaviour(const StateSpec& spec) const {
    require(std::isfinite(spec.motility), spec, "motility must be a finite number");
    require(spec.motility == 0 || spec.motility_signal < morphogens_, spec,
            "motility_signal names a morphogen that the world does not have");
    for (const double threshold : {spec.quiescence_threshold, spec.division_threshold,
                                   spec.specialization_threshold, spec.apoptosis_threshold})
      require(threshold >= 0 && threshold <= 1, spec, "thresholds of actions are from 0 to 1");
  }

  /// What states say of earlier ones, else the mean of both.
  void resolve_adhesion() {
    const std::vector<State>& states = tree_.states;
    const std::size_t count = states.size();
    tree_.adhesion.resize(count * count);
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t a = 0; a <= b; ++a) {
        const bool given = a < adhesion_with_[b].size() && !std::isnan(adhesion_with_[b][a]);
        const double mean = 0.5 * (states[a].adhesion + states[b].adhesion);
        tree_.adhesion[a * count + b] = tree_.adhesion[b * count + a] =
            given ? adhesion_with_[b][a] : mean;
      }
  }

  const std::vector<Skill>& skills_;
  std::uint32_t morphogens_;
  Tree tree_;
  std::vector<std::vector<double>> adhesion_with_;  ///< by state
};

/// The stable key of something that belongs to a state. The state's key is scrambled first
/// (splitmix64), so that names that run together ("a" + "bc", "ab" + "c") do not meet.
std::uint64_t key_of(const State& owner, std::string_view name) {
  std::uint64_t k = owner.key + 0x9E3779B97F4A7C15ull;
  k = (k ^ (k >> 30)) * 0xBF58476D1CE4E5B9ull;
  k = (k ^ (k >> 27)) * 0x94D049BB133111EBull;
  return stable_key(name, k ^ (k >> 31));
}

std::string number(double x) {
  std::ostringstream out;
  out.precision(6);
  out << x;
  return out.str();
}

}  // namespace

Ports::Ports(const Tree& tree, const Schema& schema, std::size_t morphogens) {
  // Channels: what every state senses, in one order.
  std::vector<std::string> channels;
  for (std::size_t m = 0; m < morphogens; ++m) channels.push_back("morphogen." + std::to_string(m));
  in_ = {.pressure = static_cast<std::uint32_t>(morphogens),
         .energy = static_cast<std::uint32_t>(morphogens + 1),
         .ambrosia = static_cast<std::uint32_t>(morphogens + 2),
         .first_sensor = static_cast<std::uint32_t>(morphogens + 3)};
  channels.insert(channels.end(), {"pressure", "energy", "ambrosia"});
  for (const Sensor& sensor : schema.sensors) channels.push_back(sensor.name);

  // Names first: ports view into them, so the storage must not move afterwards.
  const std::size_t states = tree.states.size();
  names_.reserve(states + states * channels.size() + 5 + states + morphogens +
                 schema.resources.size());
  const auto keep = [&](std::string name) -> std::string_view {
    return names_.emplace_back(std::move(name));
  };

  for (const State& state : tree.states)
    states_.push_back({keep(state.name), state.key, state.parent});
  for (std::uint16_t s = 0; s < states; ++s)
    for (std::uint32_t c = 0; c < channels.size(); ++c)
      inputs_.push_back({keep(tree.states[s].name + "/" + channels[c]),
                         key_of(tree.states[s], channels[c]), c, s});

  const auto add_output = [&](std::string name, std::uint64_t key, std::uint16_t target) {
    const auto channel = static_cast<std::uint32_t>(outputs_.size());
    outputs_.push_back({keep(std::move(name)), key, channel, target});
    return channel;
  };
  const auto plain = [&](const std::string& name) {
    return add_output(name, stable_key(name), no_state);
  };
  out_.quiescence = plain("quiescence");
  out_.division = plain("division");
  out_.apoptosis = plain("apoptosis");
  out_.specialize.assign(states, 0);
  for (std::uint16_t s = 1; s < states; ++s)
    out_.specialize[s] =
        add_output("specialize." + tree.states[s].name, key_of(tree.states[s], "specialize"), s);
  for (std::size_t m = 0; m < morphogens; ++m)
    out_.morphogens.push_back(plain("morphogen." + std::to_string(m)));
  out_.conversion = plain("conversion");
  out_.diffusion = plain("diffusion");
  for (const Resource& resource : schema.resources)
    out_.uptakes.push_back(plain("uptake." + resource.name));

  layout_ = {.states = states_,
             .inputs = inputs_,
             .outputs = outputs_,
             .input_channels = static_cast<std::uint32_t>(channels.size())};
}

Ecosystem::Ecosystem(Config config, std::vector<NamedEnvironment> environments,
                     std::shared_ptr<Specialization> specialization,
                     std::shared_ptr<Controller> controller, std::shared_ptr<Fitness> fitness)
    : config_(std::move(config)),
      info_{.radius = config_.radius,
            .max_steps = config_.max_steps,
            .substeps = config_.mechanics.substeps,
            .time_step = config_.mechanics.time_step},
      schema_(core_schema()),
      environments_(std::move(environments)),
      specialization_(std::move(specialization)),
      controller_(std::move(controller)),
      fitness_(std::move(fitness)) {
  // Environments declare, in the experiment's order; the fitness last.
  for (std::uint32_t i = 0; i < environments_.size(); ++i) {
    const NamedEnvironment& environment = environments_[i];
    SchemaBuilder builder(schema_, info_, environment.name);
    guarded(environment.name, "declare", [&] { environment.instance->declare(builder); });
    for (unsigned phase = 0; phase < acting_.size(); ++phase)
      if ((builder.phases() >> phase & 1u) != 0) acting_[phase].push_back(i);
  }
  SchemaBuilder builder(schema_, info_, "fitness");
  const std::size_t sensors = schema_.sensors.size();
  guarded("fitness", "declare", [&] { fitness_->declare(builder); });
  if (builder.phases() != 0 || schema_.sensors.size() != sensors)
    throw PluginFailure("fitness", "declare",
                        "a fitness observes: it has no phases and no sensors");
  for (const NamedEnvironment& environment : environments_) {
    SchemaConnections connections(schema_, environment.name);
    guarded(environment.name, "connect", [&] { environment.instance->connect(connections); });
  }
  const std::vector<SkillInfo> skills = schema_.skill_infos();
  guarded("specialization", "declare", [&] { specialization_->declare(skills); });

  // A fixed tree is grown once, here, so that its errors show at load time.
  if (specialization_->heritable() == nullptr) {
    tree_ = grow({});
    ports_ = ports_of(*tree_);
  }
}

std::shared_ptr<const Tree> Ecosystem::grow(GenesView genes) const {
  TreeBuilder builder(schema_.skills, config_.morphogens.kinds.size());
  const std::vector<SkillInfo> skills = schema_.skill_infos();
  auto tree = guarded("specialization", "grow", [&] {
    specialization_->grow(genes, skills, builder);
    return std::make_shared<const Tree>(builder.take());
  });

  // The stiffest, stickiest and lightest a pair of this tree can be.
  double stiffness = 0, adhesion = 0, mass = std::numeric_limits<double>::infinity();
  for (const State& state : tree->states) {
    stiffness = std::max(stiffness, state.stiffness);
    mass = std::min(mass, state.mass);
  }
  for (const double strength : tree->adhesion) adhesion = std::max(adhesion, strength);
  const Mechanics& m = config_.mechanics;
  const double limit = stable_time_step(stiffness, adhesion, mass, m.damping, m.drag);
  if (m.time_step > limit) throw UnstableTimeStep(m.time_step, limit);
  return tree;
}

std::shared_ptr<const Ports> Ecosystem::ports_of(const Tree& tree) const {
  return std::make_shared<const Ports>(tree, schema_, config_.morphogens.kinds.size());
}

Phenotype Ecosystem::express(const Genome& genome) const {
  Phenotype phenotype;
  phenotype.tree = tree_ ? tree_ : grow(genome.tree);
  phenotype.ports = ports_ ? ports_ : ports_of(*phenotype.tree);
  phenotype.program = guarded("controller", "express", [&] {
    std::unique_ptr<Program> program =
        controller_->express(genome.controller, phenotype.ports->layout());
    if (program == nullptr) throw std::runtime_error("it returned no program");
    constexpr std::uint32_t most = 100'000;
    if (const std::uint32_t rows = program->memory_per_cell(); rows > most)
      throw std::runtime_error("its program wants " + std::to_string(rows) +
                               " numbers of memory per cell; at most " + std::to_string(most) +
                               " are allowed");
    return program;
  });
  return phenotype;
}

double stable_time_step(double stiffness, double adhesion, double mass, double damping,
                        double drag) {
  const double k = 13.0 * (stiffness + adhesion) / (2.0 * mass);
  const double c = (13.0 * damping / 2.0 + drag) / mass;
  // Its limit without springs.
  if (k == 0) return c == 0 ? std::numeric_limits<double>::infinity() : 1.0 / c;
  return (std::sqrt(c * c + 4.0 * k) - c) / (2.0 * k);
}

UnstableTimeStep::UnstableTimeStep(double time_step, double limit)
    : std::runtime_error("a substep of " + number(time_step) +
                         " is unstable in a packed cluster of this tree's cells; at most " +
                         number(limit) +
                         " is allowed (with more substeps of less time a step stays as long)") {}

}  // namespace somas::model
