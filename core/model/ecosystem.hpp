// An experiment wired together: plugin instances, what they declared, the tree and the ports.
// Built once, immutable afterwards, shared by all simulations and threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "somas/sdk/controller.hpp"
#include "somas/sdk/environment.hpp"
#include "somas/sdk/fitness.hpp"
#include "somas/sdk/specialization.hpp"

#include "core/model/config.hpp"
#include "core/model/schema.hpp"

namespace somas::model {

/// An environment under the name that the experiment gives it.
struct NamedEnvironment {
  std::string name;
  std::shared_ptr<Environment> instance;
};

/// Least outputs for actions to be chosen; single precision, as outputs are.
struct Thresholds {
  float quiescence = 0, division = 0, specialization = 0, apoptosis = 0;
};

/// A state with all its attributes resolved.
struct State {
  std::string name;
  std::uint64_t key = 0;
  std::uint16_t parent = no_state;
  double mass = 1, radius = 1, stiffness = 10, adhesion = 3, adhesion_range = 1.2;
  double motility = 0;                ///< force along the gradient of a morphogen
  std::uint32_t motility_signal = 0;  ///< which one; below their number unless motility is 0
  Thresholds thresholds{};
  std::vector<double> skills;           ///< by skill Id
  std::vector<std::uint16_t> children;  ///< ascending

  [[nodiscard]] double skill(Id id) const { return skills[id]; }
};

/// A validated specialization tree: one root, at index 0, parents before children.
struct Tree {
  std::vector<State> states;
  std::vector<double> adhesion;  ///< of every two states: states x states, symmetric

  /// Strength of the adhesion spring between cells of two states.
  [[nodiscard]] double adhesion_between(std::size_t a, std::size_t b) const {
    return adhesion[a * states.size() + b];
  }
};

/// Output channels of a layout, by meaning.
struct OutputChannels {
  std::uint32_t quiescence = 0, division = 0, apoptosis = 0, conversion = 0, diffusion = 0;
  std::vector<std::uint32_t> specialize;  ///< by target state; [0] unused
  std::vector<std::uint32_t> morphogens;
  std::vector<std::uint32_t> uptakes;  ///< by resource
};

/// Input channels of a layout, by meaning: morphogens, pressure, energy, ambrosia, sensors.
struct InputChannels {
  std::uint32_t pressure = 0, energy = 0, ambrosia = 0, first_sensor = 0;
};

/// The ports of a tree, with the storage behind the Layout.
class Ports {
 public:
  Ports(const Tree& tree, const Schema& schema, std::size_t morphogens);
  Ports(const Ports&) = delete;
  Ports& operator=(const Ports&) = delete;

  [[nodiscard]] const Layout& layout() const { return layout_; }
  [[nodiscard]] const InputChannels& in() const { return in_; }
  [[nodiscard]] const OutputChannels& out() const { return out_; }

 private:
  std::vector<StateInfo> states_;
  std::vector<std::string> names_;
  std::vector<Port> inputs_, outputs_;
  Layout layout_;
  InputChannels in_;
  OutputChannels out_;
};

/// One genome: a chromosome per heritable part, the controller's first, then the tree's if it
/// evolves.
struct Genome {
  Genes controller;
  Genes tree;

  [[nodiscard]] std::size_t length() const { return controller.size() + tree.size(); }
  friend bool operator==(const Genome&, const Genome&) = default;
};

/// A genome made ready to live: immutable, usable by many simulations at once.
struct Phenotype {
  std::shared_ptr<const Tree> tree;
  std::shared_ptr<const Ports> ports;
  std::unique_ptr<const Program> program;
};

/// A failure inside a plugin, named by instance and call ("particles: act(stress) at step 12").
class PluginFailure : public std::runtime_error {
 public:
  PluginFailure(std::string instance, std::string call, const std::string& what)
      : std::runtime_error(instance + ": " + call + ": " + what),
        instance_(std::move(instance)),
        call_(std::move(call)) {}
  [[nodiscard]] const std::string& instance() const { return instance_; }
  [[nodiscard]] const std::string& call() const { return call_; }

 private:
  std::string instance_, call_;
};

/// A ParameterError together with the instance whose parameter it is: an environment's name, or
/// "specialization", "controller", "fitness".
class WiringError : public ParameterError {
 public:
  WiringError(std::string instance, std::string path, const std::string& what)
      : ParameterError(std::move(path), what), instance_(std::move(instance)) {}
  [[nodiscard]] const std::string& instance() const { return instance_; }

 private:
  std::string instance_;
};

class Ecosystem {
 public:
  /// Wires: environments declare, the tree resolves against the skills, ports follow, stability is
  /// checked. Throws WiringError, PluginFailure, or UnstableTimeStep.
  Ecosystem(Config config, std::vector<NamedEnvironment> environments,
            std::shared_ptr<Specialization> specialization, std::shared_ptr<Controller> controller,
            std::shared_ptr<Fitness> fitness);

  [[nodiscard]] const Config& config() const { return config_; }
  [[nodiscard]] const WorldInfo& info() const { return info_; }
  [[nodiscard]] const Schema& schema() const { return schema_; }
  [[nodiscard]] const std::vector<NamedEnvironment>& environments() const { return environments_; }
  /// Indices of the environments that act in a phase, in the experiment's order.
  [[nodiscard]] const std::vector<std::uint32_t>& acting(Phase phase) const {
    return acting_[static_cast<unsigned>(phase)];
  }
  [[nodiscard]] const Controller& controller() const { return *controller_; }
  [[nodiscard]] const Specialization& specialization() const { return *specialization_; }
  [[nodiscard]] const Fitness& fitness() const { return *fitness_; }
  /// The fixed tree and its ports; null when the tree evolves.
  [[nodiscard]] const std::shared_ptr<const Tree>& fixed_tree() const { return tree_; }
  [[nodiscard]] const std::shared_ptr<const Ports>& fixed_ports() const { return ports_; }

  /// The tree of `genes` (ignored by a fixed tree) and its ports.
  [[nodiscard]] std::shared_ptr<const Tree> grow(GenesView genes) const;
  [[nodiscard]] std::shared_ptr<const Ports> ports_of(const Tree& tree) const;
  [[nodiscard]] Phenotype express(const Genome& genome) const;

 private:
  Config config_;
  WorldInfo info_;
  Schema schema_;
  std::vector<NamedEnvironment> environments_;
  std::array<std::vector<std::uint32_t>, phase_count> acting_;
  std::shared_ptr<Specialization> specialization_;
  std::shared_ptr<Controller> controller_;
  std::shared_ptr<Fitness> fitness_;
  std::shared_ptr<const Tree> tree_;
  std::shared_ptr<const Ports> ports_;
};

/// The largest stable substep of a packed cluster (section 3):
/// h = (sqrt(C^2 + 4K) - C) / (2K), K = 13 (k_c + k_a) / (2 m), C = (13 c / 2 + drag) / m.
[[nodiscard]] double stable_time_step(double stiffness, double adhesion, double mass,
                                      double damping, double drag);

/// The experiment's substep exceeds stable_time_step of its tree.
class UnstableTimeStep : public std::runtime_error {
 public:
  UnstableTimeStep(double time_step, double limit);
};

}  // namespace somas::model
