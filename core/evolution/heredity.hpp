// The parts of an organism that evolve, and the variation of whole genomes made from theirs.
#pragma once

#include <functional>
#include <memory>

#include "somas/sdk/heritable.hpp"

#include "core/evolution/population.hpp"

namespace somas::evolution {

/// Variation of genomes: the controller's chromosome and, if it evolves, the tree's.
///
/// The tree comes first, since it decides the ports that the controller's genes must fit. Parents
/// of different trees are crossed as they are: what a controller learned for the ports that only
/// one of them has is handed down whole (Heritable::cross). All calls are const and pure functions
/// of their arguments. A part that throws becomes a model::PluginFailure of "controller" or
/// "specialization".
class Heredity {
 public:
  /// A layout together with what keeps its storage alive.
  using SharedLayout = std::shared_ptr<const Layout>;
  /// The ports of the tree that these genes encode.
  using PortsOfTree = std::function<SharedLayout(GenesView)>;

  /// A fixed tree with these ports. `controller` must outlive this.
  Heredity(const Heritable& controller, SharedLayout ports);
  /// An evolving tree. Both parts must outlive this.
  Heredity(const Heritable& controller, const Heritable& tree, PortsOfTree ports);
  /// The parts of an ecosystem, which must outlive this.
  explicit Heredity(const model::Ecosystem& ecosystem);

  [[nodiscard]] model::Genome random(Rng& rng) const;
  /// The offspring of two parents.
  [[nodiscard]] model::Genome cross(const model::Genome& first, const model::Genome& second,
                                    Rng& rng) const;
  /// One mutation event in one part; with two parts, either is as likely.
  void mutate(model::Genome& genome, Rng& rng) const;
  /// Makes a genome of another experiment fit this one; one that fits is left untouched.
  void conform(model::Genome& genome, Rng& rng) const;
  /// Throws std::runtime_error unless the genome is well formed and fits.
  void check(const model::Genome& genome) const;

  [[nodiscard]] const Heritable& controller() const { return *controller_; }
  /// Null for a fixed tree.
  [[nodiscard]] const Heritable* tree() const { return tree_; }

 private:
  [[nodiscard]] SharedLayout ports_of(const model::Genome& genome) const;

  const Heritable* controller_;
  const Heritable* tree_ = nullptr;
  SharedLayout fixed_ports_;
  PortsOfTree ports_of_tree_;
};

}  // namespace somas::evolution
