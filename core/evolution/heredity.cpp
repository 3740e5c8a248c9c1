#include "core/evolution/heredity.hpp"

#include <exception>
#include <new>
#include <utility>

#include "core/model/call_site.hpp"

namespace somas::evolution {
namespace {

// A tree's genes have no ports of their own.
const Layout no_ports{};

/// Calls into a plugin; what it throws is named after the part and the call.
template <class Call>
auto guarded(const char* part, const char* name, const Call& call) {
  const model::PluginCall here(part, name);
  try {
    return call();
  } catch (const model::PluginFailure&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
  } catch (const std::exception& error) {
    throw model::PluginFailure(part, name, error.what());
  } catch (...) {
    throw model::PluginFailure(part, name, "an exception that is no std::exception");
  }
}

Heredity::SharedLayout layout_of(std::shared_ptr<const model::Ports> ports) {
  const Layout& layout = ports->layout();
  return Heredity::SharedLayout(std::move(ports), &layout);
}

}  // namespace

Heredity::Heredity(const Heritable& controller, SharedLayout ports)
    : controller_(&controller), fixed_ports_(std::move(ports)) {}

Heredity::Heredity(const Heritable& controller, const Heritable& tree, PortsOfTree ports)
    : controller_(&controller), tree_(&tree), ports_of_tree_(std::move(ports)) {}

Heredity::Heredity(const model::Ecosystem& ecosystem)
    : controller_(&ecosystem.controller().heritable()),
      tree_(ecosystem.specialization().heritable()) {
  if (tree_ == nullptr) {
    fixed_ports_ = layout_of(ecosystem.fixed_ports());
    return;
  }
  ports_of_tree_ = [&ecosystem](GenesView genes) {
    return layout_of(ecosystem.ports_of(*ecosystem.grow(genes)));
  };
}

Heredity::SharedLayout Heredity::ports_of(const model::Genome& genome) const {
  if (tree_ == nullptr) return fixed_ports_;
  return guarded("specialization", "grow", [&] { return ports_of_tree_(genome.tree); });
}

model::Genome Heredity::random(Rng& rng) const {
  model::Genome genome;
  if (tree_ != nullptr)
    guarded("specialization", "random", [&] { tree_->random(no_ports, rng, genome.tree); });
  const SharedLayout ports = ports_of(genome);
  guarded("controller", "random", [&] { controller_->random(*ports, rng, genome.controller); });
  return genome;
}

model::Genome Heredity::cross(const model::Genome& first, const model::Genome& second,
                              Rng& rng) const {
  model::Genome child;
  if (tree_ != nullptr)
    guarded("specialization", "cross",
            [&] { tree_->cross(no_ports, first.tree, second.tree, rng, child.tree); });
  const SharedLayout ports = ports_of(child);
  guarded("controller", "cross", [&] {
    controller_->cross(*ports, first.controller, second.controller, rng, child.controller);
  });
  return child;
}

void Heredity::mutate(model::Genome& genome, Rng& rng) const {
  const bool in_tree = tree_ != nullptr && rng.chance(0.5);
  if (in_tree)
    guarded("specialization", "mutate", [&] { tree_->mutate(no_ports, rng, genome.tree); });
  const SharedLayout ports = ports_of(genome);
  if (in_tree)
    guarded("controller", "conform", [&] { controller_->conform(*ports, rng, genome.controller); });
  else
    guarded("controller", "mutate", [&] { controller_->mutate(*ports, rng, genome.controller); });
}

void Heredity::conform(model::Genome& genome, Rng& rng) const {
  // A genome of a fixed tree has no tree genes yet, and one of an evolving tree may have too many.
  if (tree_ == nullptr)
    genome.tree.clear();
  else if (genome.tree.empty())
    guarded("specialization", "random", [&] { tree_->random(no_ports, rng, genome.tree); });
  else
    guarded("specialization", "conform", [&] { tree_->conform(no_ports, rng, genome.tree); });
  const SharedLayout ports = ports_of(genome);
  guarded("controller", "conform", [&] { controller_->conform(*ports, rng, genome.controller); });
}

void Heredity::check(const model::Genome& genome) const {
  // What check throws is its answer.
  if (tree_ != nullptr) {
    const model::PluginCall here("specialization", "check");
    tree_->check(no_ports, genome.tree);
  }
  const SharedLayout ports = ports_of(genome);
  const model::PluginCall here("controller", "check");
  controller_->check(*ports, genome.controller);
}

}  // namespace somas::evolution
