/// @file
/// Layouts for the checks of genes and controllers, with the ports that the host wires.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "somas/sdk/layout.hpp"

namespace somas::testing {

/// A layout that owns its names. Every state has an input a channel, called "STATE/CHANNEL"; the
/// first state is the root, the parent of all others. An output "specialize.STATE" belongs to that
/// state, every other one to none. Keys hang on the names alone.
class PortTable {
 public:
  /// The names of states, of the channels that each of them has, and of the outputs; channels are
  /// numbered in these orders.
  PortTable(const std::vector<std::string>& states, const std::vector<std::string>& channels,
            const std::vector<std::string>& outputs) {
    for (const std::string& state : states) {
      const auto index = static_cast<std::uint16_t>(states_.size());
      states_.push_back({keep(state), stable_key(state), index == 0 ? no_state : std::uint16_t{0}});
      for (std::uint32_t c = 0; c < channels.size(); ++c) {
        const std::string_view name = keep(state + "/" + channels[c]);
        inputs_.push_back({name, stable_key(name), c, index});
      }
    }
    for (std::uint32_t c = 0; c < outputs.size(); ++c) {
      const std::string_view name = keep(outputs[c]);
      outputs_.push_back({name, stable_key(name), c, target_of(name)});
    }
    channels_ = static_cast<std::uint32_t>(channels.size());
  }
  /// The names move along.
  PortTable(PortTable&&) = default;
  /// The names move along.
  PortTable& operator=(PortTable&&) = default;

  /// Valid as long as this table.
  [[nodiscard]] Layout layout() const { return {states_, inputs_, outputs_, channels_}; }

 private:
  std::string_view keep(std::string name) { return names_.emplace_back(std::move(name)); }
  [[nodiscard]] std::uint16_t target_of(std::string_view output) const {
    for (std::uint16_t s = 0; s < states_.size(); ++s)
      if (output == "specialize." + std::string(states_[s].name)) return s;
    return no_state;
  }

  std::deque<std::string> names_;
  std::vector<StateInfo> states_;
  std::vector<Port> inputs_, outputs_;
  std::uint32_t channels_ = 0;
};

/// One state and the model's own ports; three states with an environment's sensor and resource; and
/// that one's ports in another order. The second and third hold all ports of the first.
[[nodiscard]] inline std::vector<PortTable> usual_ports() {
  std::vector<PortTable> tables;
  tables.emplace_back(std::vector<std::string>{"root"},
                      std::vector<std::string>{"morphogen.0", "pressure", "energy", "ambrosia"},
                      std::vector<std::string>{"quiescence", "division", "apoptosis", "morphogen.0",
                                               "conversion", "diffusion"});
  tables.emplace_back(
      std::vector<std::string>{"root", "left", "right"},
      std::vector<std::string>{"morphogen.0", "morphogen.1", "pressure", "energy", "ambrosia",
                               "food"},
      std::vector<std::string>{"quiescence", "division", "apoptosis", "specialize.left",
                               "specialize.right", "morphogen.0", "morphogen.1", "conversion",
                               "diffusion", "uptake.food"});
  tables.emplace_back(
      std::vector<std::string>{"root", "right", "left"},
      std::vector<std::string>{"food", "ambrosia", "energy", "pressure", "morphogen.1",
                               "morphogen.0"},
      std::vector<std::string>{"uptake.food", "diffusion", "conversion", "morphogen.1",
                               "morphogen.0", "specialize.right", "specialize.left", "apoptosis",
                               "division", "quiescence"});
  return tables;
}

}  // namespace somas::testing
